// libFuzzer: any bytes to a WALTER.
//
// A second parser, written line by line from the protocol's page (W1, W2, W6, W8..W10), gets the same bytes: what acts at once, what
// waits, what is taken out and when, and every count have to be the same. Whatever came, attention (W7) and the
// emergency stop (W8) leave the robot as they promise.
//
// Input: a byte, odd: begins in direct control, the next four bits: groups; eight bytes, whose bits say after which
// bytes a command is taken; then what arrives.
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <deque>
#include <string>

#include "../../src/Turtlewire.h"
#include "check.h"

namespace {

using turtlewire::walter::Message;
using turtlewire::walter::Mode;
using namespace turtlewire::walter;

const size_t HEAD = 9;

struct Entry {
  const char* letters;
  size_t arguments;
  Id id;
};

const Entry LINES[] = {
    {"2", 0, SELECT_DIRECT},  {"F", 2, FORWARD},         {"B", 2, BACK},       {"V", 1, SET_SPEED},
    {"L", 2, LEFT},           {"R", 2, RIGHT},           {"PU", 0, PEN_UP},    {"PD", 0, PEN_DOWN},
    {"H0", 0, HORN_OFF},      {"HL", 0, HORN_LOW},       {"HH", 0, HORN_HIGH}, {"E1", 0, LAMP_ON},
    {"E0", 0, LAMP_OFF},      {"CR", 0, RESET_LOCATION}, {"C0", 0, GO_HOME},   {"CH", 2, TURN_TO},
    {"CL", 4, GO_TO},         {"CX", 2, GO_TO_X},        {"CY", 2, GO_TO_Y},   {"QT", 4, QUERY_TOWARDS},
    {"QH", 0, QUERY_HEADING}, {"QL", 0, QUERY_LOCATION}, {"QX", 0, QUERY_X},   {"QY", 0, QUERY_Y},
    {"QP", 0, QUERY_PEN},
};

const Entry KEYS[] = {
    {" ", 0, STOP},           {"1", 0, SELECT_LOGO},    {"A", 0, START_FORWARD}, {"Z", 0, START_BACKWARD},
    {"D", 0, MOVE_FASTER},    {"C", 0, MOVE_SLOWER},    {"F", 0, TURN_FASTER},   {"V", 0, TURN_SLOWER},
    {"S", 0, RAISE_PEN},      {"X", 0, LOWER_PEN},      {",", 0, START_LEFT},    {".", 0, START_RIGHT},
    {"G", 1, SET_MOVE_SPEED}, {"B", 1, SET_TURN_SPEED},
};

// A message with its arguments, as a text to compare.
std::string shown(Id id, const std::string& arguments) { return std::to_string(id) + ":" + arguments; }

size_t arguments_of(Id id) {
  for (const Entry& entry : LINES) {
    if (entry.id == id) {
      return entry.arguments;
    }
  }
  return id == SET_MOVE_SPEED || id == SET_TURN_SPEED ? 1 : 0;
}

std::string shown(const Message& message) {
  const size_t size = arguments_of(message.id);
  if (size >= 2) {
    CHECK(message.u16() == message.arguments[0] * 256 + message.arguments[1]);
    CHECK(static_cast<uint16_t>(message.i16()) == message.u16());
  }
  if (size == 4) {
    CHECK(message.u16(1) == message.arguments[2] * 256 + message.arguments[3]);
  }
  return shown(message.id, std::string(reinterpret_cast<const char*>(message.arguments), size));
}

// The page's robot. A line is what has come since the last one ended; it is looked at anew with every byte.
class Model {
 public:
  Model(bool direct, unsigned groups) : direct_(direct), groups_(groups) {}

  void receive(char byte) {
    if (may_skip_lf_) {
      may_skip_lf_ = false;
      if (byte == '\n') {
        return;
      }
    }
    line_ += byte;
    if (direct_) {
      key();
    } else if (dropping_) {
      drop(byte);
    } else {
      line(byte);
    }
  }

  std::string at_once;
  std::deque<std::string> queue;
  unsigned malformed = 0, overflowed = 0, heard = 0;

  bool is_direct() const { return direct_; }
  size_t pending() const { return line_.size(); }

 private:
  static char upper(char letter) { return letter >= 'a' && letter <= 'z' ? static_cast<char>(letter - 32) : letter; }

  bool has(char letter) const {
    const size_t place = std::string("CQHE").find(letter);
    return place == std::string::npos || (groups_ >> place & 1U) != 0;
  }

  void line(char byte) {
    if (line_ == "\r") {
      end();
      ++heard;
      may_skip_lf_ = true;
      return;
    }
    for (const Entry& entry : LINES) {
      const std::string letters = entry.letters;
      const size_t size = letters.size() + entry.arguments;
      std::string begin = line_.substr(0, letters.size());
      for (char& letter : begin) {
        letter = upper(letter);
      }
      if (letters.compare(0, begin.size(), begin) != 0 || !has(letters[0])) {
        continue;
      }
      if (line_.size() <= size) {
        return;
      }
      if (byte != '\r') {
        dropping_ = true;
        return;
      }
      complete(entry, line_.substr(letters.size(), entry.arguments));
      may_skip_lf_ = true;
      return;
    }
    dropping_ = true;
    drop(byte);
  }

  void drop(char byte) {
    if (byte == '\r') {
      end();
      ++malformed;
      may_skip_lf_ = true;
    } else if (line_.size() >= 64) {
      line_.clear();
      ++malformed;
    }
  }

  void key() {
    for (const Entry& entry : KEYS) {
      if (upper(line_[0]) == entry.letters[0]) {
        if (line_.size() > entry.arguments) {
          complete(entry, line_.substr(1));
        }
        return;
      }
    }
    const bool is_ret = line_ == "\r";
    end();
    ++(is_ret ? heard : malformed);
    may_skip_lf_ = is_ret;
  }

  void complete(const Entry& entry, const std::string& arguments) {
    const std::string text = shown(entry.id, arguments);
    end();
    ++heard;
    if (entry.id == SELECT_DIRECT) {
      queue.clear();
      at_once += "direct ";
      direct_ = true;
    } else if (is_key(entry.id)) {
      at_once += text + " ";
      direct_ = entry.id != SELECT_LOGO;
    } else if (queue.size() == 16) {
      ++overflowed;
    } else {
      queue.push_back(text);
    }
  }

  void end() {
    line_.clear();
    dropping_ = false;
  }

  bool direct_;
  unsigned groups_;
  std::string line_;
  bool dropping_ = false;
  bool may_skip_lf_ = false;
};

class Turtle {
 public:
  void key(const Message& message) {
    at_once += shown(message) + " ";
    last = message.id;
  }
  void go_direct() {
    at_once += "direct ";
    last = SELECT_DIRECT;
  }

  std::string at_once;
  Id last = EMPTY_LINE;
};

typedef turtlewire::walter::Robot<Turtle> Walter;

void send(Walter& robot, const char* bytes, size_t size) {
  for (size_t at = 0; at < size; ++at) {
    robot.receive(static_cast<uint8_t>(bytes[at]));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < HEAD) {
    return 0;
  }
  const bool direct = (data[0] & 1U) != 0;
  const uint8_t groups = (data[0] >> 1U) & 15U;
  Turtle turtle;
  Walter robot(turtle, direct ? DIRECT : LOGO, groups);
  Model model(direct, groups);
  unsigned heard = 0;
  for (size_t at = HEAD; at < size; ++at) {
    heard += robot.receive(data[at]) ? 1 : 0;
    model.receive(static_cast<char>(data[at]));
    CHECK(robot.queued() <= QUEUE_COMMANDS && robot.queued() == model.queue.size());
    CHECK(turtle.at_once == model.at_once);
    CHECK(robot.malformed() == model.malformed && robot.overflowed() == model.overflowed && heard == model.heard);
    CHECK((robot.mode() == DIRECT) == model.is_direct());
    CHECK(robot.parser().pending() == model.pending());
    turtle.at_once.clear();
    model.at_once.clear();
    const size_t place = (at - HEAD) % 64;
    if ((data[1 + place / 8] >> (place % 8) & 1U) != 0) {
      Message message;
      const bool some = robot.next_command(message);
      CHECK(some == !model.queue.empty());
      if (some) {
        CHECK(shown(message) == model.queue.front());
        model.queue.pop_front();
      }
    }
  }
  Walter stopped = robot;
  send(stopped, "\0\0\0\0\0\r2\r ", 9);
  CHECK(stopped.mode() == DIRECT && stopped.queued() == 0 && turtle.last == STOP && stopped.parser().pending() == 0);
  turtle.last = EMPTY_LINE;
  send(robot, "\0\0\0\0\0\r2\r 1\r", 11);
  CHECK(robot.mode() == LOGO && robot.queued() == 0 && turtle.last == SELECT_LOGO && robot.parser().pending() == 0);
  return 0;
}
