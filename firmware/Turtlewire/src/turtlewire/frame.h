// frame, the robot's end: A3-framed messages of a dialect, with a CRC-8 (F1..F13 in the protocol's decisions).
//
// No heap, no Arduino.h, no clock of its own: bytes and the time in, messages out. The dialect is a header that
// `turtlewire dialect header FILE` makes; three come with this library. See examples/FrameRobot.
#ifndef TURTLEWIRE_FRAME_H
#define TURTLEWIRE_FRAME_H

#include <stdint.h>
#include <string.h>

namespace turtlewire {
namespace frame {

const uint8_t MAGIC = 0xA3;
const uint8_t HEADER = 3;
const uint8_t OVERHEAD = 4;
const uint8_t MAX_PAYLOAD = 124;
const uint8_t MAX_FRAME = 128;
// A partial frame is given up after a pause this long (F5).
const uint16_t INTER_BYTE_MS = 100;
// For received bytes. Those beyond a frame's are there so that the rest is moved only once in as many bytes.
const uint8_t ROOM = MAX_FRAME + 8;

// What has come; each counts modulo 65536. The reasons for which a frame is ignored are counted separately (F3).
struct Statistics {
  uint16_t frames;     // that count, empty ones included
  uint16_t oversized;  // size above 124
  uint16_t wrong_crc;
  uint16_t incomplete;    // given up after the inter-byte timeout
  uint16_t unknown_type;  // the CRC was right
  uint16_t inconsistent;  // the CRC was right, but a message is cut short
  uint16_t refused;       // messages that broke their restriction (F4)
  uint16_t lost;          // frames missing in the sequence (F6)
  uint16_t repeats;
  uint16_t restarts;
};

// Bytes to messages, at 115200 on a chip of 16 MHz whatever comes: every byte goes into a CRC once, however many frames
// may seem to begin around it. Dialect is the struct of that name in a dialect's header. Handler has:
//
//   void message(const M& message);    // for each message M of the dialect to the robot: carry it out
//   void heard();                      // a frame counted: what feeds a watchdog
template <class Dialect, class Handler>
class Robot {
 public:
  explicit Robot(Handler& handler) : handler_(handler) {}

  // Takes one byte that came at a time in milliseconds, of any clock that goes on and may wrap.
  void receive(uint8_t byte, uint32_t now_ms) {
    pass(now_ms);
    last_ms_ = now_ms;
    if (end_ == ROOM) {
      make_room();
    }
    buffer_[end_] = byte;
    crcs_[end_] = crc_;
    crc_ = Dialect::step(crc_, byte);
    ++end_;
    scan(false);
  }

  // Lets time pass: gives up a partial frame that is too old (F5). To be called now and then.
  void pass(uint32_t now_ms) {
    if (begin_ != end_ && now_ms - last_ms_ >= INTER_BYTE_MS) {
      scan(true);
    }
  }

  const Statistics& statistics() const { return statistics_; }

  // How many bytes of a partial frame are kept: at most 127.
  uint8_t pending() const { return static_cast<uint8_t>(end_ - begin_); }

 private:
  // F5: after what is no frame, look again from the byte after the failed magic.
  void scan(bool ended) {
    uint8_t at = begin_;
    while (at < end_) {
      if (buffer_[at] != MAGIC) {
        ++at;
        continue;
      }
      const auto rest = static_cast<uint8_t>(end_ - at);
      const uint8_t* const start = buffer_ + at;
      if (rest >= HEADER && start[2] > MAX_PAYLOAD) {
        ++statistics_.oversized;
        ++at;
      } else if (rest >= OVERHEAD && rest >= start[2] + OVERHEAD) {
        if (Dialect::is_right(start, crcs_ + at)) {
          take(start);
          at = static_cast<uint8_t>(at + start[2] + OVERHEAD);
        } else {
          ++statistics_.wrong_crc;
          ++at;
        }
      } else if (ended) {
        ++statistics_.incomplete;
        ++at;
      } else {
        break;
      }
    }
    begin_ = at;
  }

  // A partial frame has at most 127 bytes: there is always something before it.
  void make_room() {
    end_ = pending();
    memmove(buffer_, buffer_ + begin_, end_);
    memmove(crcs_, crcs_ + begin_, end_);
    begin_ = 0;
  }

  // A frame whose CRC is right is consumed whole; it counts whole or not at all (F3).
  void take(const uint8_t* start) {
    follow(start[1]);
    const uint8_t* const payload = start + HEADER;
    const uint8_t size = start[2];
    for (uint8_t at = 0; at < size;) {
      const uint8_t step = Dialect::size(payload[at]);
      if (step == 0) {
        ++statistics_.unknown_type;
        return;
      }
      if (step > size - at) {
        ++statistics_.inconsistent;
        return;
      }
      at = static_cast<uint8_t>(at + step);
    }
    ++statistics_.frames;
    handler_.heard();
    for (uint8_t at = 0; at < size; at = static_cast<uint8_t>(at + Dialect::size(payload[at]))) {
      if (!Dialect::dispatch(payload + at, handler_)) {
        ++statistics_.refused;
      }
    }
  }

  // F6: reported, never enforced.
  void follow(uint8_t seq) {
    const int16_t due = due_;
    due_ = static_cast<uint8_t>(seq + 1U);
    if (due < 0 || due == seq) {
      return;
    }
    if (due_ == due) {
      ++statistics_.repeats;
    } else if (seq == 0) {
      ++statistics_.restarts;
    } else {
      statistics_.lost = static_cast<uint16_t>(statistics_.lost + static_cast<uint8_t>(seq - due));
    }
  }

  Handler& handler_;
  Statistics statistics_{};
  uint8_t buffer_[ROOM]{};
  uint8_t crcs_[ROOM]{};  // of all that came before the byte at the same place
  uint8_t crc_ = 0;       // of all that came
  uint8_t begin_ = 0;     // of the partial frame in the buffer, and its end
  uint8_t end_ = 0;
  int16_t due_ = -1;  // the next sequence number, or -1 before the first frame
  uint32_t last_ms_ = 0;
};

// Messages to frames: telemetry, where the dialect has some (F11). Counts the sequence number (F6). A robot that sends
// little saves RAM where it has room for less than the largest payload.
template <class Dialect, uint8_t PAYLOAD = MAX_PAYLOAD>
class Sender {
 public:
  // Adds a message to the frame that is being made; false: there is no room, send it first (F9).
  template <class Message>
  bool add(const Message& message) {
    if (size_ + Message::SIZE > PAYLOAD) {
      return false;
    }
    size_ = static_cast<uint8_t>(size_ + pack(message, frame_ + HEADER + size_));
    return true;
  }

  // Finishes the frame, which may be empty (F7): data() has so many bytes then. The next add() begins another.
  uint8_t finish() {
    const uint8_t size = Dialect::finish(frame_, seq_, size_);
    ++seq_;
    size_ = 0;
    return size;
  }

  const uint8_t* data() const { return frame_; }

 private:
  static_assert(PAYLOAD <= MAX_PAYLOAD, "a frame has at most 124 bytes of payload");

  uint8_t frame_[PAYLOAD + OVERHEAD]{};
  uint8_t seq_ = 0;
  uint8_t size_ = 0;
};

}  // namespace frame
}  // namespace turtlewire

#endif  // TURTLEWIRE_FRAME_H
