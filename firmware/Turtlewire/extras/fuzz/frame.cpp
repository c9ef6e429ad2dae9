// libFuzzer: any bytes at any times to a robot that speaks frame, in three dialects.
//
// The whole of what came is taken apart here afterwards, by the protocol's page (F3..F6), with a CRC made by long
// division; the robot, fed byte by byte, has to hand over the same messages and to count the same. A second one, whose
// clock is another and who is told the time between any two bytes, does the same. What it took, sent again, arrives
// again (F9). Whatever came, 128 bytes and two frames of a stop are heard (F13).
//
// Input: a byte: the dialect; eight bytes, whose bits say before which bytes there is a pause; then what arrives.
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <string>
#include <vector>

#include "../../src/Turtlewire.h"
#include "check.h"

namespace {

using turtlewire::frame::Statistics;

const size_t HEAD = 9;
typedef std::vector<uint8_t> Bytes;

// Polynomial x^8 + x^2 + x + 1: what is left of a division of all bits.
uint8_t remainder(const uint8_t* bytes, size_t size) {
  unsigned rest = 0;
  for (size_t bit = 0; bit < 8 * (size + 1); ++bit) {
    const unsigned next = bit < 8 * size ? bytes[bit / 8] >> (7 - bit % 8) & 1U : 0;
    rest = rest << 1U | next;
    if ((rest & 0x100U) != 0) {
      rest ^= 0x107U;
    }
  }
  return static_cast<uint8_t>(rest);
}

// Takes messages down as their bytes, and sends them again.
template <class Dialect>
class Robot {
 public:
  typedef turtlewire::frame::Robot<Dialect, Robot> End;

  template <class Message>
  void message(const Message& message) {
    uint8_t packed[Message::SIZE];
    CHECK(pack(message, packed) == Message::SIZE && valid(message));
    taken.insert(taken.end(), packed, packed + Message::SIZE);
    if (!sender_.add(message)) {
      flush();
      CHECK(sender_.add(message));
    }
  }
  void heard() { ++frames; }

  // All that was taken since the last time is a frame more.
  void flush() {
    const uint8_t size = sender_.finish();
    CHECK(size <= turtlewire::frame::MAX_FRAME);
    sent.insert(sent.end(), sender_.data(), sender_.data() + size);
  }

  Bytes taken;
  Bytes sent;
  unsigned frames = 0;

 private:
  turtlewire::frame::Sender<Dialect> sender_;
};

// A message of these bytes, read and written again, if it keeps its restrictions.
class Again {
 public:
  template <class Message>
  void message(const Message& message) {
    bytes.resize(Message::SIZE);
    pack(message, bytes.data());
  }
  Bytes bytes;
};

// What the page says of all bytes that came without a pause in which a partial frame is given up.
template <class Dialect>
class Model {
 public:
  void receive(const Bytes& bytes, bool ended) {
    size_t at = 0;
    while (at < bytes.size()) {
      const size_t rest = bytes.size() - at;
      const uint8_t* const start = bytes.data() + at;
      if (start[0] != 0xA3) {
        ++at;
      } else if (rest >= 3 && start[2] > 124) {
        ++counts.oversized;
        ++at;
      } else if (rest < 3 || rest < start[2] + 4U) {
        if (!ended) {
          break;
        }
        ++counts.incomplete;
        ++at;
      } else if (remainder(start, start[2] + 3U) != start[start[2] + 3]) {
        ++counts.wrong_crc;
        ++at;
      } else {
        frame(start[1], Bytes(start + 3, start + 3 + start[2]));
        at += start[2] + 4U;
      }
    }
    pending = bytes.size() - at;
  }

  Statistics counts = Statistics();
  Bytes taken;
  size_t pending = 0;

 private:
  void frame(uint8_t seq, const Bytes& payload) {
    if (known_) {
      const uint8_t ahead = static_cast<uint8_t>(seq - last_);
      if (ahead == 0) {
        ++counts.repeats;
      } else if (ahead != 1 && seq == 0) {
        ++counts.restarts;
      } else {
        counts.lost = static_cast<uint16_t>(counts.lost + ahead - 1);
      }
    }
    known_ = true;
    last_ = seq;
    Bytes all;
    unsigned refused = 0;
    for (size_t at = 0; at < payload.size();) {
      const size_t step = Dialect::size(payload[at]);
      if (step == 0) {
        ++counts.unknown_type;
        return;
      }
      if (step > payload.size() - at) {
        ++counts.inconsistent;
        return;
      }
      Again again;
      refused += Dialect::dispatch(payload.data() + at, again) ? 0 : 1;
      all.insert(all.end(), again.bytes.begin(), again.bytes.end());
      at += step;
    }
    ++counts.frames;
    counts.refused = static_cast<uint16_t>(counts.refused + refused);
    taken.insert(taken.end(), all.begin(), all.end());
  }

  bool known_ = false;
  uint8_t last_ = 0;
};

bool same(const Statistics& one, const Statistics& other) { return memcmp(&one, &other, sizeof one) == 0; }

template <class Dialect>
void stop_is_heard(typename Robot<Dialect>::End& end, Robot<Dialect>& robot, uint32_t now_ms, const Bytes& stop) {
  uint8_t frame[turtlewire::frame::MAX_FRAME];
  size_t after = 0;
  for (size_t sent = 0; after < 2; after += sent >= 128 ? 1 : 0) {
    memcpy(frame + 3, stop.data(), stop.size());
    const uint8_t size = Dialect::finish(frame, 0, static_cast<uint8_t>(stop.size()));
    robot.taken.clear();
    for (uint8_t at = 0; at < size; ++at) {
      end.receive(frame[at], now_ms);
    }
    sent += size;
  }
  CHECK(robot.taken.size() >= stop.size() &&
        memcmp(robot.taken.data() + robot.taken.size() - stop.size(), stop.data(), stop.size()) == 0);
  CHECK(end.pending() == 0);
}

template <class Dialect>
void fuzz(const uint8_t* data, size_t size, const Bytes& stop) {
  Robot<Dialect> robot, other;
  typename Robot<Dialect>::End end(robot), told(other);
  Model<Dialect> model;
  Bytes since;
  const uint32_t offset_ms = 0xFFFFFF00U;
  uint32_t now_ms = 0;
  for (size_t at = HEAD; at < size; ++at) {
    const size_t place = (at - HEAD) % 64;
    const bool pause = (data[1 + place / 8] >> (place % 8) & 1U) != 0;
    now_ms += pause ? 100 : 99;
    if (pause && model.pending != 0) {
      model.receive(since, true);
      since.clear();
    }
    told.pass(offset_ms + now_ms);
    CHECK(pause ? told.pending() == 0 : told.pending() == end.pending());
    end.receive(data[at], now_ms);
    told.receive(data[at], offset_ms + now_ms);
    told.pass(offset_ms + now_ms + 99);
    since.push_back(data[at]);
    model.receive(since, false);
    since.erase(since.begin(), since.end() - static_cast<std::ptrdiff_t>(model.pending));
    CHECK(end.pending() == model.pending && end.pending() < turtlewire::frame::MAX_FRAME);
  }
  CHECK(robot.taken == model.taken && robot.frames == model.counts.frames && same(end.statistics(), model.counts));
  CHECK(other.taken == robot.taken && same(told.statistics(), end.statistics()));
  robot.flush();
  Robot<Dialect> second;
  typename Robot<Dialect>::End again(second);
  for (const uint8_t byte : robot.sent) {
    again.receive(byte, 0);
  }
  CHECK(second.taken == robot.taken && again.pending() == 0);
  stop_is_heard<Dialect>(end, robot, now_ms, stop);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < HEAD) {
    return 0;
  }
  const Bytes engines = {1, 0, 0, 1, 1, 0};
  switch (data[0] % 3) {
    case 0: fuzz<frame_0_1::Dialect>(data, size, engines); break;
    case 1: fuzz<frame_0_1_literal::Dialect>(data, size, engines); break;
    default: fuzz<frame_telemetry::Dialect>(data, size, Bytes{0x10, 0, 0, 0, 0}); break;
  }
  return 0;
}
