// The robots' ends on a PC, for tests of any language: commands on standard input, what comes of them on standard output.
//
//   simple [LETTER]           a new robot; LETTER: an extension command, twice 000..180 (S10)
//   walter [logo|direct MASK] a new robot with these groups (bits C 1, Q 2, H 4, E 8)
//   frame DIALECT             a new robot: 0.1, 0.1-literal or telemetry
//   bytes HEX [MS]            bytes arrive, at a time in milliseconds
//   constants                 what the headers say besides
//   stop                      simple: what a watchdog does
//   take                      walter: the next command, or `none`
//   abandon                   walter: forget the queue
//   reply LETTER VALUE        walter: the bytes of a reply; also `location X Y`, `pen 0|1`, `limit SIDE`
//   pass MS                   frame: time passes
//   message HEX               frame: type and fields of a message, to all that reads and makes some; valid ones go
//                             into the next frame
//   finish                    frame: that frame
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
  // Any other command, with its inputs; false: this robot has none of this name.
  virtual bool command(const char* word, const char* first, const char* second) = 0;
};

bool is(const char* word, const char* name) { return strcmp(word, name) == 0; }

uint32_t time_ms(const char* text) { return static_cast<uint32_t>(strtoull(text, nullptr, 10)); }

void show_hex(const uint8_t* bytes, unsigned size) {
  for (unsigned at = 0; at < size; ++at) {
    printf("%02X", static_cast<unsigned>(bytes[at]));
  }
}

// Digits that sscanf takes in pairs, into at most `room` bytes; returns how many.
uint8_t read_hex(const char* text, uint8_t* bytes, uint8_t room) {
  unsigned byte = 0;
  uint8_t size = 0;
  for (; size < room && sscanf(text, "%2x", &byte) == 1; text += 2) {
    bytes[size++] = static_cast<uint8_t>(byte);
  }
  return size;
}

uint8_t extension_letter = 0;

bool is_extension(const uint8_t* command) {
  return command[0] == extension_letter && simple::are_digits(command + 1, 6) && memcmp(command + 1, "180", 3) <= 0 &&
         memcmp(command + 4, "180", 3) <= 0;
}

class SimpleRobot : public Robot {
 public:
  explicit SimpleRobot(uint8_t letter) : robot_(*this, letter == 0 ? nullptr : is_extension) {
    extension_letter = letter;
  }

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
  bool command(const char* word, const char* /* first */, const char* /* second */) override {
    if (is(word, "stop")) {
      robot_.stop();
    } else if (is(word, "constants")) {
      printf("baud %" PRIu32 " window %u\n", simple::BAUD, simple::MAX_WINDOW);
    } else {
      return false;
    }
    return true;
  }

 private:
  simple::Robot<SimpleRobot> robot_;
};

class WalterRobot : public Robot {
 public:
  WalterRobot() : robot_(*this), heard_(0) {}
  WalterRobot(walter::Mode mode, uint8_t groups) : robot_(*this, mode, groups), heard_(0) {}

  void key(const walter::Message& message) { show_message("key", message); }
  void go_direct() { printf("direct\n"); }

  void receive(uint8_t byte, uint32_t /* now_ms */) override { heard_ += robot_.receive(byte) ? 1U : 0U; }
  bool command(const char* word, const char* first, const char* second) override {
    uint8_t bytes[7] = {};
    if (is(word, "take")) {
      take();
    } else if (is(word, "abandon")) {
      robot_.abandon();
    } else if (is(word, "constants")) {
      printf("baud %" PRIu32 " speed %u arguments %u\n", walter::BAUD, walter::DEFAULT_SPEED, walter::MAX_ARGUMENTS);
    } else if (is(word, "reply")) {
      show_reply(bytes, walter::reply_u16(static_cast<uint8_t>(first[0]), static_cast<uint16_t>(atol(second)), bytes));
    } else if (is(word, "location")) {
      show_reply(bytes,
                 walter::reply_location(static_cast<int16_t>(atoi(first)), static_cast<int16_t>(atoi(second)), bytes));
    } else if (is(word, "pen")) {
      show_reply(bytes, walter::reply_pen(first[0] == '1', bytes));
    } else if (is(word, "limit")) {
      show_reply(bytes, walter::limit_event(static_cast<uint8_t>(first[0]), bytes));
    } else {
      return false;
    }
    return true;
  }
  void show() override {
    printf("= pending %u mode %s queued %u heard %u malformed %u overflowed %u\n", robot_.parser().pending(),
           robot_.mode() == walter::LOGO ? "logo" : "direct", robot_.queued(), heard_, robot_.malformed(),
           robot_.overflowed());
  }

 private:
  void take() {
    walter::Message message;
    if (robot_.next_command(message)) {
      show_message("command", message);
    } else {
      printf("none\n");
    }
  }
  static void show_reply(const uint8_t* bytes, uint8_t size) {
    printf("sends ");
    show_hex(bytes, size);
    printf("\n");
  }
  static void show_message(const char* what, const walter::Message& message) {
    printf("%s %u ", what, static_cast<unsigned>(message.id));
    show_hex(message.arguments, walter::MAX_ARGUMENTS);
    printf(" u8 %u u16 %u %u i16 %d %d\n", message.u8(), message.u16(), message.u16(1), message.i16(), message.i16(1));
  }

  walter::Robot<WalterRobot> robot_;
  unsigned heard_;
};

// What the headers of dialects have besides messages.
struct Traits01 {
  typedef frame_0_1::Dialect Dialect;
  static uint8_t telemetry_size(uint8_t /* type */) { return 0; }
  static void show_constants() {
    using namespace frame_0_1;
    printf("frame %u payload %u\n", +MAX_FRAME, +MAX_PAYLOAD);
    printf("baud %" PRIu32 " engines %u servos %u\n", BAUD, COUNT_ENGINES, COUNT_SERVOS);
  }
};

struct TraitsLiteral {
  typedef frame_0_1_literal::Dialect Dialect;
  static uint8_t telemetry_size(uint8_t /* type */) { return 0; }
  static void show_constants() {
    using namespace frame_0_1_literal;
    printf("frame %u payload %u\n", +MAX_FRAME, +MAX_PAYLOAD);
    printf("baud %" PRIu32 " engines %u servos %u\n", BAUD, COUNT_ENGINES, COUNT_SERVOS);
  }
};

struct TraitsTelemetry {
  typedef frame_telemetry::Dialect Dialect;
  static uint8_t telemetry_size(uint8_t type) { return frame_telemetry::telemetry_size(type); }
  static void show_constants() {
    using namespace frame_telemetry;
    printf("frame %u payload %u\n", +MAX_FRAME, +MAX_PAYLOAD);
    printf("baud %" PRIu32 " servos %u\n", BAUD, COUNT_SERVOS);
    printf("state %u %u %u %u\n", state::idle, state::driving, state::stopped, state::fault);
    printf("tone %u %u %u\n", tone::off, tone::low, tone::high);
  }
};

// A robot of a dialect, all of whose messages are named.
template <class Traits, class... Messages>
class FrameRobot : public Robot {
 public:
  typedef typename Traits::Dialect Dialect;

  FrameRobot() : robot_(*this) {}

  template <class Message>
  void message(const Message& message) {
    uint8_t bytes[Message::SIZE];
    show_hex((pack(message, bytes), bytes), Message::SIZE);
    printf(" message\n");
  }
  void heard() { printf("heard\n"); }

  void receive(uint8_t byte, uint32_t now_ms) override { robot_.receive(byte, now_ms); }
  void show() override {
    const frame::Statistics& s = robot_.statistics();
    printf(
        "= pending %u frames %u oversized %u wrong_crc %u incomplete %u unknown_type %u inconsistent %u refused %u "
        "lost %u repeats %u restarts %u\n",
        robot_.pending(), s.frames, s.oversized, s.wrong_crc, s.incomplete, s.unknown_type, s.inconsistent, s.refused,
        s.lost, s.repeats, s.restarts);
  }
  bool command(const char* word, const char* first, const char* /* second */) override {
    if (is(word, "pass")) {
      robot_.pass(time_ms(first));
    } else if (is(word, "constants")) {
      printf("frame %u payload %u\n", frame::MAX_FRAME, frame::MAX_PAYLOAD);
      Traits::show_constants();
      const int done[] = {(show_layout<Messages>(), 0)...};
      static_cast<void>(done);
    } else if (is(word, "message")) {
      take_apart(first);
    } else if (is(word, "finish")) {
      const uint8_t size = sender_.finish();
      printf("sends ");
      show_hex(sender_.data(), size);
      printf("\n");
    } else {
      return false;
    }
    return true;
  }

 private:
  void take_apart(const char* text) {
    uint8_t bytes[frame::MAX_PAYLOAD];
    const uint8_t size = read_hex(text, bytes, frame::MAX_PAYLOAD);
    printf("sizes %u %u\n", Dialect::size(bytes[0]), Traits::telemetry_size(bytes[0]));
    if (size >= Dialect::size(bytes[0]) && !Dialect::dispatch(bytes, *this)) {
      printf("refused\n");
    }
    const int done[] = {(read_as<Messages>(bytes, size), 0)...};
    static_cast<void>(done);
  }

  template <class Message>
  static void show_layout() {
    printf("type %u size %u\n", +Message::TYPE, +Message::SIZE);
  }

  template <class Message>
  void read_as(const uint8_t* bytes, uint8_t size) {
    Message read = Message();
    if (!unpack(bytes, size, read)) {
      return;
    }
    uint8_t again[Message::SIZE] = {};
    const uint8_t packed = pack(read, again);
    printf("%s ", valid(read) ? "valid" : "invalid");
    show_hex(again, packed);
    printf("%s\n", valid(read) && !sender_.add(read) ? " no room" : "");
  }

  frame::Robot<Dialect, FrameRobot> robot_;
  frame::Sender<Dialect> sender_;
};

Robot* frame_robot(const char* dialect) {
  if (is(dialect, "0.1")) {
    using namespace frame_0_1;
    return new FrameRobot<Traits01, SetServoPosition, EngineForward, EngineBackward>();
  }
  if (is(dialect, "0.1-literal")) {
    using namespace frame_0_1_literal;
    return new FrameRobot<TraitsLiteral, SetServoPosition, EngineForward, EngineBackward, EngineDirectionUnknown>();
  }
  if (is(dialect, "telemetry")) {
    using namespace frame_telemetry;
    return new FrameRobot<TraitsTelemetry, SetServoPosition, SetWheelSpeeds, SetLamp, Beep, SetPidGains, Odometry,
                          Status, Distance>();
  }
  return nullptr;
}

Robot* made(const char* kind, const char* first, const char* second) {
  if (is(kind, "simple")) {
    return new SimpleRobot(static_cast<uint8_t>(first[0]));
  }
  if (is(kind, "walter")) {
    if (first[0] == '\0') {
      return new WalterRobot();
    }
    return new WalterRobot(is(first, "direct") ? walter::DIRECT : walter::LOGO,
                           static_cast<uint8_t>(strtoul(second, nullptr, 10)));
  }
  return is(kind, "frame") ? frame_robot(first) : nullptr;
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
    if (is(word, "flush")) {
      fflush(stdout);
      continue;
    }
    if (robot != nullptr && is(word, "bytes")) {
      receive(*robot, is(first, "-") ? "" : first, time_ms(second));
    } else if (robot == nullptr || !robot->command(word, first, second)) {
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
