// A car that speaks "simple": seven characters a command, answered K or F.
//
//   wiring (Arduino Uno, Nano or Mega; motor driver such as L298N, TB6612FNG or DRV8833)
//
//   pin  goes to
//   ---  -----------------------------------------------------------------
//    5   driver, channel A, PWM: the rear motor
//    7   driver, channel A, direction: HIGH forward, LOW backward
//    6   driver, channel B, PWM: the steering motor or magnet
//    8   driver, channel B, direction: HIGH right, LOW left
//    9   headlight left upper   (a LED with 220 ohms to ground, each)
//   10   headlight left lower
//   11   headlight right upper
//   12   headlight right lower
//   0, 1 the host: USB, or a Bluetooth module
//
// Pins 5 and 6 make PWM by the same timer, which leaves the others alone. Battery of the motors: to the driver, with
// its ground joined to the Arduino's.
//
// Drive it:  turtlewire run rose.logo --port /dev/ttyUSB0 --robot simple
#include <Turtlewire.h>

namespace {

const uint32_t BAUD = turtlewire::simple::BAUD;  // 9600; the host is to be told of another one
const uint16_t WATCHDOG_MS = 0;                  // 0: none. Else: no valid command for so long stops the motors
const bool SELF_TEST = true;                     // all headlights for a moment at power-on

const uint8_t DRIVE_PWM = 5;
const uint8_t DRIVE_DIRECTION = 7;
const uint8_t STEER_PWM = 6;
const uint8_t STEER_DIRECTION = 8;
const uint8_t HEADLIGHTS[] = {9, 10, 11, 12};
const uint16_t SELF_TEST_MS = 100;

// What the commands do to the pins.
struct Car {
  void drive(int16_t pwm) { turn(DRIVE_PWM, DRIVE_DIRECTION, pwm); }
  void steer(int16_t pwm) { turn(STEER_PWM, STEER_DIRECTION, pwm); }

  void headlights(bool left_upper, bool left_lower, bool right_upper, bool right_lower) {
    const bool on[] = {left_upper, left_lower, right_upper, right_lower};
    for (uint8_t light = 0; light < sizeof HEADLIGHTS; ++light) {
      digitalWrite(HEADLIGHTS[light], on[light] ? HIGH : LOW);
    }
  }

  void extension(const turtlewire::simple::Parser& /* command */) {}

  static void turn(uint8_t pwm_pin, uint8_t direction_pin, int16_t pwm) {
    digitalWrite(direction_pin, pwm >= 0 ? HIGH : LOW);
    analogWrite(pwm_pin, pwm >= 0 ? pwm : -pwm);
  }
};

Car car;
turtlewire::simple::Robot<Car> robot(car);
uint32_t heard_ms = 0;
bool is_testing = SELF_TEST;

}  // namespace

void setup() {
  for (uint8_t pin = DRIVE_PWM; pin <= HEADLIGHTS[3]; ++pin) {
    pinMode(pin, OUTPUT);
  }
  robot.stop();
  car.headlights(SELF_TEST, SELF_TEST, SELF_TEST, SELF_TEST);
  Serial.begin(BAUD);
}

void loop() {
  while (Serial.available() > 0) {
    const uint8_t answer = robot.receive(static_cast<uint8_t>(Serial.read()));
    if (answer != 0) {
      Serial.write(answer);
    }
    if (answer == turtlewire::simple::ACCEPTED) {
      heard_ms = millis();
      is_testing = false;
    }
  }
  if (is_testing && millis() >= SELF_TEST_MS) {
    is_testing = false;
    car.headlights(false, false, false, false);
  }
  if (WATCHDOG_MS > 0 && millis() - heard_ms > WATCHDOG_MS) {
    robot.stop();
  }
}
