// libFuzzer: any bytes to a robot that speaks simple.
//
// Every seven bytes are judged here by themselves, in the words of the protocol's page (S2..S5, S10); the robot has to
// do the same, no more, and to answer once. Whatever came, the way back into step (S7) stops it.
//
// Input: a byte, odd: with an extension; then what arrives.
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <string>

#include "../../src/Turtlewire.h"
#include "check.h"

namespace {

using turtlewire::simple::Parser;
using turtlewire::simple::Robot;

bool extension(const uint8_t* command) { return command[0] == 'V' && turtlewire::simple::are_digits(command + 1, 6); }

// What a robot does: drives, steers, switches; as a text.
class Car {
 public:
  void drive(int16_t pwm) {
    CHECK(pwm >= -255 && pwm <= 255);
    note("drive", pwm);
  }
  void steer(int16_t pwm) {
    CHECK(pwm >= -255 && pwm <= 255);
    note("steer", pwm);
  }
  void headlights(bool left_upper, bool left_lower, bool right_upper, bool right_lower) {
    note("lights", left_upper * 1000 + left_lower * 100 + right_upper * 10 + right_lower);
  }
  void extension(const Parser& command) {
    note("extension", command.number(1));
    note("and", command.number(4));
  }
  void note(const char* what, int value) { done += std::string(what) + " " + std::to_string(value) + " "; }

  std::string done;
};

bool all_digits(const std::string& text) { return text.find_first_not_of("0123456789") == std::string::npos; }

// What the seven bytes want, by the page; false: they are no command.
bool wanted(const std::string& command, bool extended, Car& car) {
  const std::string number = command.substr(1, 3);
  const bool in_range = all_digits(number) && std::stoi(number) <= 255;
  switch (command[0]) {
    case 'F':
    case 'B':
    case 'L':
    case 'R': {
      if (!in_range) {
        return false;
      }
      const int value = std::stoi(number);
      const bool is_steering = command[0] == 'L' || command[0] == 'R';
      car.note(is_steering ? "steer" : "drive", command[0] == 'F' || command[0] == 'R' ? value : -value);
      return true;
    }
    case 'S': car.done = "drive 0 steer 0 "; return true;
    case 'H': {
      std::string lights = command.substr(1, 4);
      if (!all_digits(lights)) {
        return false;
      }
      for (char& light : lights) {
        light = light == '0' ? '0' : '1';
      }
      car.note("lights", std::stoi(lights));
      return true;
    }
    case 'V':
      if (!extended || !all_digits(command.substr(1))) {
        return false;
      }
      car.note("extension", std::stoi(number));
      car.note("and", std::stoi(command.substr(4)));
      return true;
    default: return false;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) {
    return 0;
  }
  const bool extended = (data[0] & 1U) != 0;
  Car car;
  Robot<Car> robot(car, extended ? extension : nullptr);
  std::string command;
  for (size_t at = 1; at < size; ++at) {
    command += static_cast<char>(data[at]);
    car.done.clear();
    const uint8_t answer = robot.receive(data[at]);
    CHECK(robot.parser().pending() == (at % 7));
    if (command.size() < 7) {
      CHECK(answer == 0 && car.done.empty());
      continue;
    }
    Car expected;
    const bool valid = wanted(command, extended, expected);
    CHECK(answer == (valid ? 'K' : 'F'));
    CHECK(car.done == expected.done);
    command.clear();
  }
  // S7: at most seven S until it answers, then it can be stopped for certain.
  int sent = 0;
  uint8_t answer = 0;
  while (answer == 0) {
    CHECK(++sent <= 7);
    answer = robot.receive('S');
  }
  car.done.clear();
  for (const char byte : std::string("S000000")) {
    answer = robot.receive(static_cast<uint8_t>(byte));
  }
  CHECK(answer == 'K' && car.done == "drive 0 steer 0 ");
  return 0;
}
