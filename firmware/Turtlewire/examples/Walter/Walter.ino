// A WALTER floor turtle: Logo control and direct control, with every command that the protocol proposes.
//
//   wiring (Arduino Uno or Mega; two stepper drivers such as A4988 or DRV8825, set to 16 microsteps)
//
//   pin  goes to
//   ---  -----------------------------------------------------------------
//    2   left driver, STEP             3   right driver, STEP
//    4   left driver, DIR              5   right driver, DIR     (HIGH: ahead)
//    6   both drivers, ENABLE (LOW: motors hold)
//    8   horn: a piezo buzzer to ground
//    9   pen servo, signal
//   13   lamp (the board's own LED, or one with 220 ohms)
//   A0   limit switch front   A1 back   A2 left   A3 right: each to ground when pressed
//   0, 1 the host: USB, or a Bluetooth module
//
// Measure and put in below: how many steps a millimetre takes, how far apart the wheels touch the ground, and where the
// pen servo is up and down. `turtlewire calibrate` finds what is left.
//
// Draw:  turtlewire run rose.logo --port /dev/ttyUSB0
#include <Turtlewire.h>
#include <turtlewire/avr/stepper_pair.h>

namespace {

using namespace turtlewire::walter;

const uint32_t BAUD_RATE = BAUD;   // 9600; the host is to be told of another one
const uint32_t WATCHDOG_MS = 0;    // 0: none. Else: nothing valid for so long stops the robot
const float STEPS_PER_MM = 16.0F;  // microsteps a turn of the motor / circumference of the wheel in mm
const float TRACK_MM = 140.0F;     // between the wheels' points of contact
const uint16_t PEN_UP_US = 1000;   // the servo's pulses
const uint16_t PEN_DOWN_US = 1600;
const uint16_t PEN_MS = 100;  // how long it takes to get there
const uint16_t HORN_LOW_HZ = 440;
const uint16_t HORN_HIGH_HZ = 880;
const uint16_t SELF_TEST_MS = 100;  // the lamp, at power-on

const uint8_t ENABLE_PIN = 6;
const uint8_t HORN_PIN = 8;
const uint8_t LAMP_PIN = 13;
const uint8_t SWITCH_PINS[] = {A0, A1, A2, A3};
const uint8_t SIDES[] = {'F', 'B', 'L', 'R'};
enum Side : uint8_t { FRONT, REAR };

const float HALF_MM_PER_STEP = 2.0F / STEPS_PER_MM;
const float DEG_PER_STEP = 360.0F / (static_cast<float>(PI) * TRACK_MM * STEPS_PER_MM);
const uint32_t FASTEST_TICKS = 200;  // 10,000 steps a second

// A heading as 0 <= h < 360.
float around(float deg) {
  deg = fmod(deg, 360.0F);
  return deg < 0.0F ? deg + 360.0F : deg;
}

// The same direction, the shorter way: -180 < a <= 180.
float shorter(float deg) {
  deg = around(deg);
  return deg > 180.0F ? deg - 360.0F : deg;
}

// The nearest whole number of units, as the wire carries it.
int16_t rounded(float value) { return static_cast<int16_t>(value < 0.0F ? value - 0.5F : value + 0.5F); }

struct Turtle {
  void key(const Message& message);
  void go_direct() { halt(); }

  void begin(const Message& message);
  void go_on();
  void halt();
  void look();
  bool is_idle() const { return !is_moving && legs_left == 0 && !is_waiting; }

 private:
  struct Leg {
    bool is_turn;
    float amount;  // half millimetres ahead, or degrees clockwise
  };

  void add_turn(float deg) { add(true, deg); }
  void add_move(float half_mm) { add(false, half_mm); }
  void add(bool is_turn, float amount);
  void go_to(float to_x, float to_y, bool keeps_heading);
  void start(bool is_turn, bool ahead, uint32_t steps);
  void account(bool is_complete);
  void move_pen(bool down);
  void wait(uint16_t ms);
  void answer(const Message& message);
  void send(uint8_t size) { Serial.write(out, size); }
  uint32_t pace() const;
  bool is_pressed(uint8_t side) const { return digitalRead(SWITCH_PINS[side]) == LOW; }
  void tell_limit(uint8_t side);
  float bearing(float to_x, float to_y) const { return around(degrees(atan2(to_x - x, to_y - y))); }

  float x = 0.0F;  // half millimetres
  float y = 0.0F;
  float heading = 0.0F;  // degrees, 0 = +Y, clockwise
  // What is missing from the last turn and the last move because it was less than half a step: the next one makes up
  // for it. 59 steps for 3 degrees, which are 58.6, would be 7 degrees too many once round a circle.
  float owed_deg = 0.0F;
  float owed_half_mm = 0.0F;
  uint8_t move_speed = DEFAULT_SPEED;
  uint8_t turn_speed = DEFAULT_SPEED;
  bool is_pen_down = false;

  Leg legs[3] = {};
  uint8_t legs_left = 0;
  Leg leg = {false, 0.0F};
  bool is_moving = false;
  bool is_ahead = false;
  bool is_endless = false;
  bool is_waiting = false;
  uint32_t waits_until_ms = 0;
  uint8_t pressed = 0;  // the switches, a bit each
  uint8_t out[8] = {};
};

Turtle turtle;
Robot<Turtle> robot(turtle);
uint32_t heard_ms = 0;
bool is_testing = true;

// ---------------------------------------------------------------------- Logo control: one command at a time

void Turtle::begin(const Message& message) {
  switch (message.id) {
    case FORWARD: add_move(message.u16()); break;
    case BACK: add_move(-static_cast<float>(message.u16())); break;
    case RIGHT: add_turn(message.u16()); break;
    case LEFT: add_turn(-static_cast<float>(message.u16())); break;
    case SET_SPEED: move_speed = turn_speed = message.u8(); break;
    case PEN_UP: move_pen(false); break;
    case PEN_DOWN: move_pen(true); break;
    case HORN_OFF: noTone(HORN_PIN); break;
    case HORN_LOW: tone(HORN_PIN, HORN_LOW_HZ); break;
    case HORN_HIGH: tone(HORN_PIN, HORN_HIGH_HZ); break;
    case LAMP_ON: digitalWrite(LAMP_PIN, HIGH); break;
    case LAMP_OFF: digitalWrite(LAMP_PIN, LOW); break;
    case RESET_LOCATION: x = y = 0.0F; break;
    case GO_HOME: go_to(0.0F, 0.0F, false); break;
    case TURN_TO: add_turn(shorter(message.u16() - heading - owed_deg)); break;
    case GO_TO: go_to(message.i16(0), message.i16(1), true); break;
    case GO_TO_X: go_to(message.i16(), y, true); break;
    case GO_TO_Y: go_to(x, message.i16(), true); break;
    default: answer(message); break;
  }
}

void Turtle::answer(const Message& message) {
  switch (message.id) {
    case QUERY_TOWARDS:
      send(reply_u16('T', static_cast<uint16_t>(rounded(bearing(message.i16(0), message.i16(1))) % 360), out));
      break;
    case QUERY_HEADING: send(reply_u16('H', static_cast<uint16_t>(rounded(heading) % 360), out)); break;
    case QUERY_LOCATION: send(reply_location(rounded(x), rounded(y), out)); break;
    case QUERY_X: send(reply_u16('X', static_cast<uint16_t>(rounded(x)), out)); break;
    case QUERY_Y: send(reply_u16('Y', static_cast<uint16_t>(rounded(y)), out)); break;
    case QUERY_PEN: send(reply_pen(is_pen_down, out)); break;
    default: break;
  }
}

// There by the straight way; only to its home it comes as it goes (W10).
void Turtle::go_to(float to_x, float to_y, bool keeps_heading) {
  const float distance = hypot(to_x - x, to_y - y);
  if (distance < HALF_MM_PER_STEP / 2.0F) {  // it is there: a bearing to that place would mean nothing
    return;
  }
  const float turn = shorter(bearing(to_x, to_y) - heading - owed_deg);
  add_turn(turn);
  add_move(distance);
  if (keeps_heading) {
    add_turn(-turn);
  }
}

void Turtle::add(bool is_turn, float amount) {
  if (amount != 0.0F) {
    legs[legs_left] = {is_turn, amount};
    ++legs_left;
  }
}

void Turtle::move_pen(bool down) {
  if (down != is_pen_down) {
    is_pen_down = down;
    steppers.set_servo(down ? PEN_DOWN_US : PEN_UP_US);
    wait(PEN_MS);
  }
}

void Turtle::wait(uint16_t ms) {
  is_waiting = true;
  waits_until_ms = millis() + ms;
}

// ------------------------------------------------------------------------------------- direct control: keys

void Turtle::key(const Message& message) {
  switch (message.id) {
    case STOP: halt(); break;
    case SELECT_LOGO: halt(); break;
    case START_FORWARD: start(false, true, turtlewire::avr::FOREVER); break;
    case START_BACKWARD: start(false, false, turtlewire::avr::FOREVER); break;
    case START_RIGHT: start(true, true, turtlewire::avr::FOREVER); break;
    case START_LEFT: start(true, false, turtlewire::avr::FOREVER); break;
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
  if (is_moving) {
    steppers.set_pace(pace());
  }
}

// -------------------------------------------------------------------------------------------- motion itself

// Ticks from step to step at the speed that is set; a unit is a millimetre, or a degree, a second (W14).
uint32_t Turtle::pace() const {
  const uint8_t speed = leg.is_turn ? turn_speed : move_speed;
  if (speed == 0) {
    return 0;
  }
  const float steps_per_s = leg.is_turn ? speed / DEG_PER_STEP : speed * STEPS_PER_MM;
  const uint32_t ticks = static_cast<uint32_t>(turtlewire::avr::TICKS_PER_S / steps_per_s);
  return ticks < FASTEST_TICKS ? FASTEST_TICKS : ticks;
}

// `ahead`: a turn's clockwise.
void Turtle::start(bool is_turn, bool ahead, uint32_t steps) {
  if (is_moving) {
    steppers.stop();
    account(false);
  }
  const uint8_t side = ahead ? FRONT : REAR;
  if (!is_turn && is_pressed(side)) {  // W13: not towards what is touched
    tell_limit(side);
    return;
  }
  leg.is_turn = is_turn;
  is_ahead = ahead;
  is_endless = steps == turtlewire::avr::FOREVER;
  is_moving = true;
  steppers.start(ahead, ahead != is_turn, steps, pace());
}

// The pose after the steps that were made: all of the leg's, or some.
void Turtle::account(bool is_complete) {
  is_moving = false;
  const float steps = is_ahead ? steppers.done() : -static_cast<float>(steppers.done());
  const float moved = steps * (leg.is_turn ? DEG_PER_STEP : HALF_MM_PER_STEP);
  (leg.is_turn ? owed_deg : owed_half_mm) = is_complete ? leg.amount - moved : 0.0F;
  if (leg.is_turn) {
    heading = around(heading + moved);
    return;
  }
  const float angle = radians(heading);
  x += sin(angle) * moved;
  y += cos(angle) * moved;
}

// To be called again and again: what is done, what comes next.
void Turtle::go_on() {
  if (is_waiting && static_cast<int32_t>(millis() - waits_until_ms) >= 0) {
    is_waiting = false;
  }
  if (is_moving && steppers.is_done()) {
    account(true);
  }
  if (is_moving || is_waiting || legs_left == 0) {
    return;
  }
  leg = legs[0];
  legs[0] = legs[1];
  legs[1] = legs[2];
  --legs_left;
  leg.amount += leg.is_turn ? owed_deg : owed_half_mm;
  const float per_step = leg.is_turn ? DEG_PER_STEP : HALF_MM_PER_STEP;
  start(leg.is_turn, leg.amount > 0.0F, static_cast<uint32_t>(fabs(leg.amount) / per_step + 0.5F));
}

void Turtle::halt() {
  steppers.stop();
  if (is_moving) {
    account(false);
  }
  legs_left = 0;
}

// ------------------------------------------------------------------------------------------- limit switches

void Turtle::tell_limit(uint8_t side) {
  halt();
  robot.abandon();
  send(limit_event(SIDES[side], out));
}

// W13: a switch that closes ends what goes on. A turn on the spot is always free.
void Turtle::look() {
  for (uint8_t side = 0; side < sizeof SWITCH_PINS; ++side) {
    const uint8_t bit = static_cast<uint8_t>(1U << side);
    const bool was_pressed = (pressed & bit) != 0;
    if (!is_pressed(side)) {
      pressed &= static_cast<uint8_t>(~bit);
    } else if (!was_pressed) {
      pressed |= bit;
      if (is_moving && !leg.is_turn) {
        tell_limit(side);
      }
    }
  }
}

}  // namespace

void setup() {
  pinMode(ENABLE_PIN, OUTPUT);
  digitalWrite(ENABLE_PIN, LOW);
  pinMode(LAMP_PIN, OUTPUT);
  digitalWrite(LAMP_PIN, HIGH);
  for (uint8_t pin : SWITCH_PINS) {
    pinMode(pin, INPUT_PULLUP);
  }
  steppers.begin(2, 3, 4, 5, 9);
  steppers.set_servo(PEN_UP_US);
  Serial.begin(BAUD_RATE);
}

void loop() {
  while (Serial.available() > 0) {
    if (robot.receive(static_cast<uint8_t>(Serial.read()))) {
      heard_ms = millis();
    }
  }
  turtle.look();
  turtle.go_on();
  Message message;
  while (turtle.is_idle() && robot.next_command(message)) {
    turtle.begin(message);
    turtle.go_on();
  }
  if (is_testing && millis() >= SELF_TEST_MS) {
    is_testing = false;
    digitalWrite(LAMP_PIN, LOW);
  }
  if (WATCHDOG_MS > 0 && millis() - heard_ms > WATCHDOG_MS) {
    robot.abandon();
    turtle.halt();
  }
}
