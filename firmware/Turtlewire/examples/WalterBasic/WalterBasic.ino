// A WALTER floor turtle without the commands that the protocol marks as proposed: moves, turns, pen, direct control.
//
// It answers nothing, so the host goes by the time that a motion takes, keeps the pose itself, and draws with it all the
// same (W9, W10). For small boards, and as the shortest way to a turtle that draws; Walter has everything.
//
//   wiring: as for Walter, without horn, lamp and limit switches
//
//   pin  goes to
//   ---  -----------------------------------------------------------------
//    2   left driver, STEP             3   right driver, STEP
//    4   left driver, DIR              5   right driver, DIR     (HIGH: ahead)
//    6   both drivers, ENABLE (LOW: motors hold)
//    9   pen servo, signal
//   0, 1 the host: USB, or a Bluetooth module
//
// Draw:  turtlewire run rose.logo --port /dev/ttyUSB0
#include <Turtlewire.h>
#include <turtlewire/avr/stepper_pair.h>

namespace {

using namespace turtlewire::walter;
using turtlewire::avr::FOREVER;

const uint32_t BAUD_RATE = BAUD;   // 9600; the host is to be told of another one
const uint32_t WATCHDOG_MS = 0;    // 0: none. Else: nothing valid for so long stops the robot
const float STEPS_PER_MM = 16.0F;  // microsteps a turn of the motor / circumference of the wheel in mm
const float TRACK_MM = 140.0F;     // between the wheels' points of contact
const uint16_t PEN_UP_US = 1000;   // the servo's pulses
const uint16_t PEN_DOWN_US = 1600;
const uint16_t PEN_MS = 100;  // how long it takes to get there

const uint8_t ENABLE_PIN = 6;
const float STEPS_PER_DEG = static_cast<float>(PI) * TRACK_MM * STEPS_PER_MM / 360.0F;
const uint32_t FASTEST_TICKS = 200;  // 10,000 steps a second

struct Turtle {
  void key(const Message& message);
  void go_direct() { halt(); }

  void begin(const Message& message);
  void halt() { steppers.stop(); }
  bool is_idle() const { return steppers.is_done() && static_cast<int32_t>(millis() - pen_until_ms) >= 0; }

 private:
  void move(float half_mm) { go(false, half_mm * STEPS_PER_MM / 2.0F, owed_move); }
  void turn(float deg) { go(true, deg * STEPS_PER_DEG, owed_turn); }

  // A number of steps that is no whole one: what is missing, or too much, the next one makes up for.
  void go(bool turns, float steps, float& owed) {
    const int32_t whole = lround(steps + owed);
    owed += steps - whole;
    start(turns, whole > 0, static_cast<uint32_t>(labs(whole)));
  }

  void start(bool turns, bool ahead, uint32_t steps) {
    is_turn = turns;
    steppers.start(ahead, ahead != turns, steps, pace());
  }

  // Ticks from step to step; a unit of speed is a millimetre, or a degree, a second (W14).
  uint32_t pace() const {
    const float steps_per_s = is_turn ? turn_speed * STEPS_PER_DEG : move_speed * STEPS_PER_MM;
    if (steps_per_s == 0.0F) {
      return 0;
    }
    const uint32_t ticks = static_cast<uint32_t>(turtlewire::avr::TICKS_PER_S / steps_per_s);
    return ticks < FASTEST_TICKS ? FASTEST_TICKS : ticks;
  }

  void move_pen(bool down) {
    steppers.set_servo(down ? PEN_DOWN_US : PEN_UP_US);
    pen_until_ms = millis() + PEN_MS;
  }

  uint8_t move_speed = DEFAULT_SPEED;
  uint8_t turn_speed = DEFAULT_SPEED;
  bool is_turn = false;
  float owed_move = 0.0F;  // steps, less than one
  float owed_turn = 0.0F;
  uint32_t pen_until_ms = 0;
};

Turtle turtle;
Robot<Turtle> robot(turtle, LOGO, 0);
uint32_t heard_ms = 0;

void Turtle::begin(const Message& message) {
  switch (message.id) {
    case FORWARD: move(message.u16()); break;
    case BACK: move(-static_cast<float>(message.u16())); break;
    case RIGHT: turn(message.u16()); break;
    case LEFT: turn(-static_cast<float>(message.u16())); break;
    case SET_SPEED: move_speed = turn_speed = message.u8(); break;
    case PEN_UP: move_pen(false); break;
    case PEN_DOWN: move_pen(true); break;
    default: break;
  }
}

void Turtle::key(const Message& message) {
  switch (message.id) {
    case STOP: halt(); break;
    case SELECT_LOGO: halt(); break;
    case START_FORWARD: start(false, true, FOREVER); break;
    case START_BACKWARD: start(false, false, FOREVER); break;
    case START_RIGHT: start(true, true, FOREVER); break;
    case START_LEFT: start(true, false, FOREVER); break;
    case MOVE_FASTER: move_speed += move_speed < UINT8_MAX; break;
    case MOVE_SLOWER: move_speed -= move_speed > 0; break;
    case TURN_FASTER: turn_speed += turn_speed < UINT8_MAX; break;
    case TURN_SLOWER: turn_speed -= turn_speed > 0; break;
    case SET_MOVE_SPEED: move_speed = message.u8(); break;
    case SET_TURN_SPEED: turn_speed = message.u8(); break;
    case RAISE_PEN: move_pen(false); break;
    case LOWER_PEN: move_pen(true); break;
    default: break;
  }
  steppers.set_pace(pace());
}

}  // namespace

void setup() {
  pinMode(ENABLE_PIN, OUTPUT);
  digitalWrite(ENABLE_PIN, LOW);
  steppers.begin(2, 3, 4, 5, 9);
  steppers.set_servo(PEN_DOWN_US);  // the self-test: the pen goes down and up
  delay(PEN_MS);
  steppers.set_servo(PEN_UP_US);
  Serial.begin(BAUD_RATE);
}

void loop() {
  while (Serial.available() > 0) {
    if (robot.receive(static_cast<uint8_t>(Serial.read()))) {
      heard_ms = millis();
    }
  }
  Message message;
  while (turtle.is_idle() && robot.next_command(message)) {
    turtle.begin(message);
  }
  if (WATCHDOG_MS > 0 && millis() - heard_ms > WATCHDOG_MS) {
    robot.abandon();
    turtle.halt();
  }
}
