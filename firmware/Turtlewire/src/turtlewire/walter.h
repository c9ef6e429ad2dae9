// WALTER, the robot's end: Logo control and direct control (W1..W16 in the protocol's decisions).
//
// No heap, no Arduino.h, no clock: bytes in, commands and keys out. See examples/Walter.
#ifndef TURTLEWIRE_WALTER_H
#define TURTLEWIRE_WALTER_H

#include <stdint.h>

#include "walter_messages.h"

namespace turtlewire {
namespace walter {

enum Mode : uint8_t { LOGO, DIRECT };

// The groups of commands that a robot may lack (W10), as bits.
enum Groups : uint8_t {
  GROUP_C = 1,
  GROUP_Q = 2,
  GROUP_H = 4,
  GROUP_E = 8,
  ALL_GROUPS = 15,
};

// A command or key, and its arguments as they came.
struct Message {
  Id id;
  uint8_t arguments[MAX_ARGUMENTS];

  uint8_t u8() const { return arguments[0]; }
  // One of the 16-bit arguments, the first or second, big endian.
  uint16_t u16(uint8_t number = 0) const {
    const auto at = static_cast<uint8_t>(2U * number);
    return static_cast<uint16_t>((static_cast<uint16_t>(arguments[at]) << 8U) | arguments[at + 1U]);
  }
  int16_t i16(uint8_t number = 0) const { return static_cast<int16_t>(u16(number)); }
};

// Bytes to messages: by length, never by looking for RET (W1); an ill-formed line is dropped up to its RET (W6).
class Parser {
 public:
  enum Result : uint8_t { NOTHING, MESSAGE, MALFORMED };

  explicit Parser(Mode mode = LOGO, uint8_t groups = ALL_GROUPS) : mode_(mode), groups_(groups) {}

  // Takes one byte. After MESSAGE, message() is what it completed; an empty line is one (EMPTY_LINE).
  Result receive(uint8_t byte);

  Mode mode() const { return mode_; }
  const Message& message() const { return message_; }

  // How many bytes of an unfinished message there are.
  uint8_t pending() const { return count_; }

 private:
  enum State : uint8_t { LETTERS, ARGUMENTS, RET, DROPPING };

  // The next byte begins a message; the mode stays.
  void reset();
  Result line_byte(uint8_t byte);
  Result key_byte(uint8_t byte);
  Result letter(uint8_t byte);
  Result drop(uint8_t byte);
  Result complete(Id id, bool ret);
  void argument(uint8_t byte);

  Mode mode_;
  uint8_t groups_;
  State state_ = LETTERS;
  bool may_skip_lf_ = false;
  uint8_t count_ = 0;
  uint8_t first_ = 0;
  uint8_t size_ = 0;
  uint8_t taken_ = 0;
  Message message_{};
};

// The parser, a queue for what is carried out in order (W9), and what may not wait. Handler has:
//
//   void key(const Message& message);    // a direct key, now
//   void go_direct();                    // `2`: the current motion ends now; the queue is empty already (W8)
template <class Handler>
class Robot {
 public:
  explicit Robot(Handler& handler, Mode mode = LOGO, uint8_t groups = ALL_GROUPS)
      : handler_(handler), parser_(mode, groups) {}

  // Takes one byte. Returns whether it completed something valid, an empty line included: what feeds a watchdog.
  bool receive(uint8_t byte) {
    switch (parser_.receive(byte)) {
      case Parser::MESSAGE: take(parser_.message()); return true;
      case Parser::MALFORMED: ++malformed_; return false;
      default: return false;
    }
  }

  // The next command to carry out, when the last one is done; false: there is none.
  bool next_command(Message& message) {
    if (queued_ == 0) {
      return false;
    }
    message = queue_[first_];
    first_ = static_cast<uint8_t>((first_ + 1U) % QUEUE_COMMANDS);
    --queued_;
    return true;
  }

  // Forgets what waits: a limit tripped (W13), or a watchdog ran out.
  void abandon() { queued_ = 0; }

  Mode mode() const { return parser_.mode(); }
  uint8_t queued() const { return queued_; }
  const Parser& parser() const { return parser_; }

  // Ill-formed lines and bytes that are no key, and commands for which there was no room; both counted modulo 65536.
  uint16_t malformed() const { return malformed_; }
  uint16_t overflowed() const { return overflowed_; }

 private:
  void take(const Message& message) {
    if (message.id == SELECT_DIRECT) {
      abandon();
      handler_.go_direct();
    } else if (is_key(message.id)) {
      handler_.key(message);
    } else if (message.id != EMPTY_LINE) {
      push(message);
    }
  }

  void push(const Message& message) {
    if (queued_ == QUEUE_COMMANDS) {
      ++overflowed_;
      return;
    }
    queue_[(first_ + queued_) % QUEUE_COMMANDS] = message;
    ++queued_;
  }

  Handler& handler_;
  Parser parser_;
  Message queue_[QUEUE_COMMANDS]{};
  uint8_t first_ = 0;
  uint8_t queued_ = 0;
  uint16_t malformed_ = 0;
  uint16_t overflowed_ = 0;
};

// The bytes of replies and events, RET included. Each writes to `out` and returns how many bytes; at most 7.
uint8_t reply_u16(uint8_t letter, uint16_t value, uint8_t* out);  // `Q` `T`|`H`|`X`|`Y` hi lo RET
uint8_t reply_location(int16_t x, int16_t y, uint8_t* out);
uint8_t reply_pen(bool down, uint8_t* out);       // the raw byte 00 or 01 (W4)
uint8_t limit_event(uint8_t side, uint8_t* out);  // side: F, B, L or R

}  // namespace walter
}  // namespace turtlewire

#endif  // TURTLEWIRE_WALTER_H
