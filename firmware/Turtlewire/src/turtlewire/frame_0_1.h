// Serial Protocol 0.1: dialect 0.1.
// Made by turtlewire from the dialect's file: do not edit.
//
// valid() tells whether a message keeps its restrictions: one that does not is not to be carried out.
// unpack() takes type and fields; it returns false where the type is another or bytes are missing.
// pack() returns how many bytes it wrote.
#ifndef TURTLEWIRE_FRAME_0_1_H
#define TURTLEWIRE_FRAME_0_1_H

#include <stdint.h>
#include <string.h>

namespace frame_0_1 {

constexpr uint32_t BAUD = 115200UL;
constexpr uint8_t FRAME_MAGIC = 0xA3;
constexpr uint8_t FRAME_HEADER = 3;
constexpr uint8_t FRAME_OVERHEAD = 4;
constexpr uint8_t MAX_PAYLOAD = 124;
constexpr uint8_t MAX_FRAME = 128;

// CRC-8/SMBUS from magic
constexpr uint8_t CRC_POLY = 0x07;
constexpr uint8_t CRC_INIT = 0x00;
constexpr uint8_t CRC_XOROUT = 0x00;
constexpr uint8_t CRC_FIRST = 0;

inline uint8_t crc8_bit(uint8_t crc) {
  return static_cast<uint8_t>((crc & 0x80U) != 0 ? (crc << 1U) ^ CRC_POLY : crc << 1U);
}

inline uint8_t crc8_step(uint8_t crc, uint8_t byte) {
  crc = static_cast<uint8_t>(crc ^ byte);
  for (uint8_t bit = 0; bit < 8; ++bit) {
    crc = crc8_bit(crc);
  }
  return crc;
}

// The product of two polynomials, the remainder of it.
inline uint8_t crc8_times(uint8_t one, uint8_t other) {
  uint8_t product = 0;
  for (uint8_t bit = 0; bit < 8; ++bit) {
    product = crc8_bit(product);
    if ((other & 0x80U) != 0) {
      product = static_cast<uint8_t>(product ^ one);
    }
    other = static_cast<uint8_t>(other << 1U);
  }
  return product;
}

// What at most 127 zero bytes make of a CRC: so many times x^8, by the binary digits of the number.
inline uint8_t crc8_zeros(uint8_t crc, uint8_t count) {
  static const uint8_t POWERS[] = {0x07, 0x15, 0x16, 0x13, 0x02, 0x04, 0x10};
  for (const uint8_t* power = POWERS; count != 0; ++power) {
    if ((count & 1U) != 0) {
      crc = crc8_times(crc, *power);
    }
    count = static_cast<uint8_t>(count >> 1U);
  }
  return crc;
}

// The CRC of a frame whose payload has `size` bytes.
inline uint8_t frame_crc(const uint8_t* frame, uint8_t size) {
  uint8_t crc = CRC_INIT;
  for (uint8_t at = CRC_FIRST; at < FRAME_HEADER + size; ++at) {
    crc = crc8_step(crc, frame[at]);
  }
  return static_cast<uint8_t>(crc ^ CRC_XOROUT);
}

// Whether a frame's CRC is right, by crc8_step() of all that came before each of its bytes, from any beginning on: what
// came before the frame follows it as zeros, and falls out.
inline bool is_right_frame(const uint8_t* frame, const uint8_t* crcs) {
  const auto end = static_cast<uint8_t>(FRAME_HEADER + frame[2]);
  const auto before = static_cast<uint8_t>(crcs[CRC_FIRST] ^ CRC_INIT);
  const auto zeros = static_cast<uint8_t>(end - CRC_FIRST);
  return (crcs[end] ^ crc8_zeros(before, zeros) ^ CRC_XOROUT) == frame[end];
}

// Makes a frame of a payload that stands at frame + FRAME_HEADER already. Returns the frame's size.
inline uint8_t finish_frame(uint8_t* frame, uint8_t seq, uint8_t size) {
  frame[0] = FRAME_MAGIC;
  frame[1] = seq;
  frame[2] = size;
  frame[FRAME_HEADER + size] = frame_crc(frame, size);
  return static_cast<uint8_t>(size + FRAME_OVERHEAD);
}

constexpr uint16_t COUNT_SERVOS = 2;
constexpr uint16_t COUNT_ENGINES = 2;

// Move a servo to an absolute position. (to robot)
struct SetServoPosition {
  static constexpr uint8_t TYPE = 0x00;
  static constexpr uint8_t SIZE = 3;
  uint8_t servo_id;  // servo number
  uint8_t position_deg;  // degrees
};

inline bool valid(const SetServoPosition& message) {
  return message.servo_id <= 1 && message.position_deg <= 180;
}

inline uint8_t pack(const SetServoPosition& message, uint8_t* out) {
  out[0] = 0x00;
  out[1] = message.servo_id;
  out[2] = message.position_deg;
  return 3;
}

inline bool unpack(const uint8_t* in, uint8_t size, SetServoPosition& message) {
  if (size < 3 || in[0] != 0x00) {
    return false;
  }
  message.servo_id = in[1];
  message.position_deg = in[2];
  return true;
}

// Turn an engine on with a speed; 0 stops it. (to robot)
struct EngineForward {
  static constexpr uint8_t TYPE = 0x01;
  static constexpr uint8_t SIZE = 3;
  uint8_t engine_id;  // engine number
  uint8_t speed;  // 0 still, 255 full speed
};

inline bool valid(const EngineForward& message) {
  return message.engine_id <= 1;
}

inline uint8_t pack(const EngineForward& message, uint8_t* out) {
  out[0] = 0x01;
  out[1] = message.engine_id;
  out[2] = message.speed;
  return 3;
}

inline bool unpack(const uint8_t* in, uint8_t size, EngineForward& message) {
  if (size < 3 || in[0] != 0x01) {
    return false;
  }
  message.engine_id = in[1];
  message.speed = in[2];
  return true;
}

// Turn an engine on in the opposite direction with a speed; 0 stops it. (to robot)
struct EngineBackward {
  static constexpr uint8_t TYPE = 0x02;
  static constexpr uint8_t SIZE = 3;
  uint8_t engine_id;  // engine number
  uint8_t speed;  // 0 still, 255 full speed
};

inline bool valid(const EngineBackward& message) {
  return message.engine_id <= 1;
}

inline uint8_t pack(const EngineBackward& message, uint8_t* out) {
  out[0] = 0x02;
  out[1] = message.engine_id;
  out[2] = message.speed;
  return 3;
}

inline bool unpack(const uint8_t* in, uint8_t size, EngineBackward& message) {
  if (size < 3 || in[0] != 0x02) {
    return false;
  }
  message.engine_id = in[1];
  message.speed = in[2];
  return true;
}

// Type and fields of a message to robot; 0 for an unknown type.
inline uint8_t command_size(uint8_t type) {
  switch (type) {
    case 0x00: return SetServoPosition::SIZE;
    case 0x01: return EngineForward::SIZE;
    case 0x02: return EngineBackward::SIZE;
    default: return 0;
  }
}

// The dialect as turtlewire's parser wants it: frame::Robot<Dialect, Handler>, frame::Sender<Dialect>.
struct Dialect {
  static uint8_t size(uint8_t type) { return command_size(type); }
  static uint8_t step(uint8_t crc, uint8_t byte) { return crc8_step(crc, byte); }
  static bool is_right(const uint8_t* frame, const uint8_t* crcs) { return is_right_frame(frame, crcs); }
  static uint8_t finish(uint8_t* frame, uint8_t seq, uint8_t size) { return finish_frame(frame, seq, size); }

  // Hands one message, all of whose bytes are there, to handler.message(); false: it breaks its restriction.
  template <class Handler>
  static bool dispatch(const uint8_t* in, Handler& handler) {
    switch (in[0]) {
      case 0x00: return hand_over<SetServoPosition>(in, handler);
      case 0x01: return hand_over<EngineForward>(in, handler);
      case 0x02: return hand_over<EngineBackward>(in, handler);
      default: return false;
    }
  }

 private:
  template <class Message, class Handler>
  static bool hand_over(const uint8_t* in, Handler& handler) {
    Message message = Message();
    static_cast<void>(unpack(in, Message::SIZE, message));  // type and size are right already
    if (!valid(message)) {
      return false;
    }
    handler.message(message);
    return true;
  }
};

}  // namespace frame_0_1

#endif  // TURTLEWIRE_FRAME_0_1_H
