// simple, the robot's end: seven characters a command, answered K or F (S1..S10 in the protocol's decisions).
//
// No heap, no Arduino.h, no clock: bytes in, calls and one answer byte out. See examples/SimpleCar.
#ifndef TURTLEWIRE_SIMPLE_H
#define TURTLEWIRE_SIMPLE_H

#include <stdint.h>

#include "simple_messages.h"

namespace turtlewire {
namespace simple {

// A command as it came: its letter, and its six positions as they were on the wire.
class Parser {
 public:
  // Whether seven bytes with a letter of one's own are a valid command (S10).
  using Extension = bool (*)(const uint8_t* command);

  explicit Parser(Extension extension = nullptr) : extension_(extension) {}

  // Takes one byte. Returns 0 while a command is incomplete, then ACCEPTED or REJECTED: exactly one after every
  // seven bytes (S4). Until the next byte, the command can be looked at.
  uint8_t receive(uint8_t byte);

  // How many bytes of an unfinished command there are: 0..6.
  uint8_t pending() const { return count_; }

  uint8_t letter() const { return command_[0]; }

  // The number of three digits at a position of an accepted command: 0..999.
  uint16_t number(uint8_t position) const;

  // Whether the digit at a position of an accepted command is not '0' (the source: "0 off, any other digit on").
  bool is_on(uint8_t position) const { return command_[position] != '0'; }

 private:
  bool valid() const;

  Extension extension_;
  uint8_t count_ = 0;
  uint8_t command_[LENGTH]{};
};

// Whether `count` characters are ASCII digits.
bool are_digits(const uint8_t* text, uint8_t count);

// What the robot has been told, and what to do about it. Handler has:
//
//   void drive(int16_t pwm);    // -255 full speed backward .. 255 full speed forward
//   void steer(int16_t pwm);    // -255 full lock left .. 255 full lock right
//   void headlights(bool left_upper, bool left_lower, bool right_upper, bool right_lower);
//   void extension(const Parser& command);    // S10: an accepted command with a letter of one's own
//
// A stop is drive(0) and steer(0) (S5).
template <class Handler>
class Robot {
 public:
  explicit Robot(Handler& handler, Parser::Extension extension = nullptr) : handler_(handler), parser_(extension) {}

  // Takes one byte; returns the byte to send, or 0 for none.
  uint8_t receive(uint8_t byte) {
    const uint8_t answer = parser_.receive(byte);
    if (answer == ACCEPTED) {
      carry_out();
    }
    return answer;
  }

  // Motors off, steering released: for a watchdog that nothing has fed (section 4).
  void stop() {
    handler_.drive(0);
    handler_.steer(0);
  }

  const Parser& parser() const { return parser_; }

 private:
  void carry_out() {
    switch (parser_.letter()) {
      case DRIVE_FORWARD: handler_.drive(value()); break;
      case DRIVE_BACKWARD: handler_.drive(static_cast<int16_t>(-value())); break;
      case STEER_LEFT: handler_.steer(static_cast<int16_t>(-value())); break;
      case STEER_RIGHT: handler_.steer(value()); break;
      case STOP: stop(); break;
      case HEADLIGHTS:
        handler_.headlights(parser_.is_on(1), parser_.is_on(2), parser_.is_on(3), parser_.is_on(4));
        break;
      default: handler_.extension(parser_); break;
    }
  }

  int16_t value() const { return static_cast<int16_t>(parser_.number(1)); }

  Handler& handler_;
  Parser parser_;
};

}  // namespace simple
}  // namespace turtlewire

#endif  // TURTLEWIRE_SIMPLE_H
