// The robots' ends on a PC, for tests of any language: commands on standard input, what comes of them on standard output.
//
//   simple [LETTER]           a new robot; LETTER: an extension command, twice 000..180 (S10)
//   walter logo|direct MASK   a new robot with these groups (bits C 1, Q 2, H 4, E 8)
//   frame DIALECT             a new robot: 0.1, 0.1-literal or telemetry
//   bytes HEX [MS]            bytes arrive, at a time in milliseconds
//   take                      walter: the next command, or `none`
//   abandon                   walter: forget the queue
//   pass MS                   frame: time passes
//   flush                     let the answers go
//
// Each command but flush is answered by lines, the last of which begins with `=` and tells the robot's state.
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../src/Turtlewire.h"

namespace {

using namespace turtlewire;

class Robot {
 public:
  virtual ~Robot() {}
  virtual void receive(uint8_t byte, uint32_t now_ms) = 0;
  virtual void show() = 0;
  virtual void take() {}
  virtual void abandon() {}
  virtual void pass(uint32_t /* now_ms */) {}
};

void show_hex(const uint8_t* bytes, unsigned size) {
  for (unsigned at = 0; at < size; ++at) {
    printf("%02X", static_cast<unsigned>(bytes[at]));
  }
}

uint8_t extension_letter = 0;

bool is_extension(const uint8_t* command) {
  return command[0] == extension_letter && simple::are_digits(command + 1, 6) && memcmp(command + 1, "180", 3) <= 0 &&
         memcmp(command + 4, "180", 3) <= 0;
}

class SimpleRobot : public Robot {
 public:
  explicit SimpleRobot(uint8_t letter) : robot_(*this, letter == 0 ? nullptr : is_extension) { extension_letter = letter; }

  void drive(int16_t pwm) { printf("drive %d\n", pwm); }
  void steer(int16_t pwm) { printf("steer %d\n", pwm); }
  void headlights(bool a, bool b, bool c, bool d) { printf("headlights %d%d%d%d\n", a, b, c, d); }
  void extension(const simple::Parser& command) {
    printf("extension %c %u %u\n", command.letter(), command.number(1), command.number(4));
  }

  void receive(uint8_t byte, uint32_t /* now_ms */) override {
    const uint8_t answer = robot_.receive(byte);
    if (answer != 0) {
      printf("answer %c\n", answer);
    }
  }
  void show() override { printf("= pending %u\n", robot_.parser().pending()); }

 private:
  simple::Robot<SimpleRobot> robot_;
};

class WalterRobot : public Robot {
 public:
  WalterRobot(walter::Mode mode, uint8_t groups) : robot_(*this, mode, groups), heard_(0) {}

  void key(const walter::Message& message) { show_message("key", message); }
  void go_direct() { printf("direct\n"); }

  void receive(uint8_t byte, uint32_t /* now_ms */) override { heard_ += robot_.receive(byte) ? 1U : 0U; }
  void take() override {
    walter::Message message;
    if (robot_.next_command(message)) {
      show_message("command", message);
    } else {
      printf("none\n");
    }
  }
  void abandon() override { robot_.abandon(); }
  void show() override {
    printf("= pending %u mode %s queued %u heard %u malformed %u overflowed %u\n", robot_.parser().pending(),
           robot_.mode() == walter::LOGO ? "logo" : "direct", robot_.queued(), heard_, robot_.malformed(),
           robot_.overflowed());
  }

 private:
  static void show_message(const char* what, const walter::Message& message) {
    printf("%s %u ", what, static_cast<unsigned>(message.id));
    show_hex(message.arguments, walter::MAX_ARGUMENTS);
    printf("\n");
  }

  walter::Robot<WalterRobot> robot_;
  unsigned heard_;
};

template <class Dialect>
class FrameRobot : public Robot {
 public:
  FrameRobot() : robot_(*this) {}

  template <class Message>
  void message(const Message& message) {
    uint8_t bytes[Message::SIZE];
    show_hex((pack(message, bytes), bytes), Message::SIZE);
    printf(" message\n");
  }
  void heard() { printf("heard\n"); }

  void receive(uint8_t byte, uint32_t now_ms) override { robot_.receive(byte, now_ms); }
  void pass(uint32_t now_ms) override { robot_.pass(now_ms); }
  void show() override {
    const frame::Statistics& s = robot_.statistics();
    printf("= pending %u frames %u oversized %u wrong_crc %u incomplete %u unknown_type %u inconsistent %u refused %u "
           "lost %u repeats %u restarts %u\n",
           robot_.pending(), s.frames, s.oversized, s.wrong_crc, s.incomplete, s.unknown_type, s.inconsistent, s.refused,
           s.lost, s.repeats, s.restarts);
  }

 private:
  frame::Robot<Dialect, FrameRobot<Dialect> > robot_;
};

Robot* frame_robot(const char* dialect) {
  if (strcmp(dialect, "0.1") == 0) {
    return new FrameRobot<frame_0_1::Dialect>();
  }
  if (strcmp(dialect, "0.1-literal") == 0) {
    return new FrameRobot<frame_0_1_literal::Dialect>();
  }
  return strcmp(dialect, "telemetry") == 0 ? new FrameRobot<frame_telemetry::Dialect>() : nullptr;
}

Robot* made(const char* kind, const char* first, const char* second) {
  if (strcmp(kind, "simple") == 0) {
    return new SimpleRobot(static_cast<uint8_t>(first[0]));
  }
  if (strcmp(kind, "walter") == 0) {
    return new WalterRobot(strcmp(first, "direct") == 0 ? walter::DIRECT : walter::LOGO,
                           static_cast<uint8_t>(strtoul(second, nullptr, 10)));
  }
  return strcmp(kind, "frame") == 0 ? frame_robot(first) : nullptr;
}

void receive(Robot& robot, const char* text, uint32_t now_ms) {
  unsigned byte = 0;
  for (; sscanf(text, "%2x", &byte) == 1; text += 2) {
    robot.receive(static_cast<uint8_t>(byte), now_ms);
  }
}

}  // namespace

int main() {
  static char line[1 << 20];
  static char first[1 << 20];
  Robot* robot = nullptr;
  while (fgets(line, sizeof line, stdin) != nullptr) {
    char word[16] = "";
    char second[32] = "0";
    first[0] = '\0';
    sscanf(line, "%15s %1048575s %31s", word, first, second);
    if (strcmp(word, "flush") == 0) {
      fflush(stdout);
      continue;
    }
    if (strcmp(word, "bytes") == 0 && robot != nullptr) {
      receive(*robot, strcmp(first, "-") == 0 ? "" : first, static_cast<uint32_t>(strtoull(second, nullptr, 10)));
    } else if (strcmp(word, "take") == 0 && robot != nullptr) {
      robot->take();
    } else if (strcmp(word, "abandon") == 0 && robot != nullptr) {
      robot->abandon();
    } else if (strcmp(word, "pass") == 0 && robot != nullptr) {
      robot->pass(static_cast<uint32_t>(strtoull(first, nullptr, 10)));
    } else {
      delete robot;
      robot = made(word, first, second);
    }
    if (robot == nullptr) {
      fprintf(stderr, "what is %s", line);
      return 2;
    }
    robot->show();
  }
  delete robot;
  return 0;
}
