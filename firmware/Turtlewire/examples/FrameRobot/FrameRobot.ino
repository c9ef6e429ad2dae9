// A robot with two engines and two servos that speaks "frame" (Serial Protocol 0.1), and reports how it is.
//
//   wiring (Arduino Uno or Nano; motor driver such as L298N, TB6612FNG or DRV8833)
//
//   pin  goes to
//   ---  -----------------------------------------------------------------
//    5   driver, channel A, PWM: engine 0, left      7   its direction: HIGH forward
//    6   driver, channel B, PWM: engine 1, right     8   its direction: HIGH forward
//    9   servo 0, signal (a pen, say)               10   servo 1, signal
//    4   bumper switch, to ground when touched
//   13   the board's own LED: lit for a moment at power-on
//   A0   battery, through 20k to it and 10k to ground
//   0, 1 the host: USB, or a Bluetooth module
//
// Messages are data: dialect.toml says what this robot understands, dialect.h is made of it. A dialect of your own:
//   turtlewire dialect header my.toml --output dialect.h
//
// Drive it:  turtlewire drive --port "/dev/ttyUSB0?protocol=frame"
#include <Turtlewire.h>

#include "dialect.h"

namespace {

using namespace frame_frame_robot;

const uint16_t WATCHDOG_MS = 0;     // 0: none. Else: no frame for so long, empty ones included, stops the engines
const uint16_t SELF_TEST_MS = 100;  // the LED, at power-on
const uint16_t STATUS_MS = 100;
const uint8_t PWM_PINS[] = {5, 6};
const uint8_t DIRECTION_PINS[] = {7, 8};
const uint8_t SERVO_PINS[] = {9, 10};
const uint8_t BUMPER_PIN = 4;
const uint8_t LED_PIN = 13;
const uint8_t BATTERY_PIN = A0;
const float VOLTS_PER_COUNT = 5.0F / 1024.0F * 3.0F;

// 0..180 degrees as 0.5..2.5 ms.
uint16_t pulse(uint8_t degrees) { return static_cast<uint16_t>(999 + degrees * 4000UL / 180); }

// Servo pulses by timer 1 itself, which makes them on pins 9 and 10 without any interrupt: 20 ms, half a microsecond a tick.
void begin_servos() {
  TCCR1A = _BV(COM1A1) | _BV(COM1B1) | _BV(WGM11);
  TCCR1B = _BV(WGM13) | _BV(WGM12);
  ICR1 = 39999;         // can be written in this mode only
  TCCR1B |= _BV(CS11);  // now it runs
  OCR1A = OCR1B = pulse(90);
  pinMode(SERVO_PINS[0], OUTPUT);
  pinMode(SERVO_PINS[1], OUTPUT);
}

// What the messages do to the pins.
struct Machine {
  void message(const SetServoPosition& servo) { (servo.servo_id == 0 ? OCR1A : OCR1B) = pulse(servo.position_deg); }
  void message(const EngineForward& engine) { turn(engine.engine_id, HIGH, engine.speed); }
  void message(const EngineBackward& engine) { turn(engine.engine_id, LOW, engine.speed); }
  void heard() { heard_ms = millis(); }

  static void turn(uint8_t engine, uint8_t direction, uint8_t speed) {
    digitalWrite(DIRECTION_PINS[engine], direction);
    analogWrite(PWM_PINS[engine], speed);
  }

  void stop() {
    turn(0, HIGH, 0);
    turn(1, HIGH, 0);
  }

  uint32_t heard_ms = 0;
};

Machine machine;
turtlewire::frame::Robot<Dialect, Machine> robot(machine);
turtlewire::frame::Sender<Dialect, Status::SIZE> sender;
uint32_t told_ms = 0;
bool is_testing = true;

void tell() {
  Status status;
  status.time_ms = millis();
  status.battery_v = analogRead(BATTERY_PIN) * VOLTS_PER_COUNT;
  status.bumper = digitalRead(BUMPER_PIN) == LOW;
  sender.add(status);
  Serial.write(sender.data(), sender.finish());
}

}  // namespace

void setup() {
  for (uint8_t pin : DIRECTION_PINS) {
    pinMode(pin, OUTPUT);
  }
  pinMode(BUMPER_PIN, INPUT_PULLUP);
  pinMode(LED_PIN, OUTPUT);
  digitalWrite(LED_PIN, HIGH);
  machine.stop();
  begin_servos();
  Serial.begin(BAUD);
}

void loop() {
  while (Serial.available() > 0) {
    robot.receive(static_cast<uint8_t>(Serial.read()), millis());
  }
  robot.pass(millis());
  // Only where there is room to send without waiting.
  if (millis() - told_ms >= STATUS_MS && Serial.availableForWrite() >= Status::SIZE + 4) {
    told_ms += STATUS_MS;
    tell();
  }
  if (is_testing && millis() >= SELF_TEST_MS) {
    is_testing = false;
    digitalWrite(LED_PIN, LOW);
  }
  if (WATCHDOG_MS > 0 && millis() - machine.heard_ms > WATCHDOG_MS) {
    machine.stop();
  }
}
