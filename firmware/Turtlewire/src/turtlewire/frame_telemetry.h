// A robot with telemetry: dialect telemetry.
// Made by turtlewire from the dialect's file: do not edit.
//
// valid() tells whether a message keeps its restrictions: one that does not is not to be carried out.
// unpack() takes type and fields; it returns false where the type is another or bytes are missing.
// pack() returns how many bytes it wrote.
#ifndef TURTLEWIRE_FRAME_TELEMETRY_H
#define TURTLEWIRE_FRAME_TELEMETRY_H

#include <stdint.h>
#include <string.h>

namespace frame_telemetry {

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

inline void put16(uint8_t* out, uint16_t value) {
  out[0] = static_cast<uint8_t>(value >> 8U);
  out[1] = static_cast<uint8_t>(value & 0xFFU);
}

inline uint16_t get16(const uint8_t* in) {
  return static_cast<uint16_t>((static_cast<uint16_t>(in[0]) << 8U) | in[1]);
}

inline void put32(uint8_t* out, uint32_t value) {
  put16(out, static_cast<uint16_t>(value >> 16U));
  put16(out + 2, static_cast<uint16_t>(value & 0xFFFFU));
}

inline uint32_t get32(const uint8_t* in) {
  return (static_cast<uint32_t>(get16(in)) << 16U) | get16(in + 2);
}

inline void put_float(uint8_t* out, float value) {
  static_assert(sizeof(float) == sizeof(uint32_t), "an f32 is an IEEE 754 single");
  uint32_t bits = 0;
  memcpy(&bits, &value, sizeof bits);
  put32(out, bits);
}

inline float get_float(const uint8_t* in) {
  const uint32_t bits = get32(in);
  float value = 0;
  memcpy(&value, &bits, sizeof value);
  return value;
}

constexpr uint16_t COUNT_SERVOS = 1;

namespace state { enum : uint32_t { idle = 0, driving = 1, stopped = 2, fault = 9 }; }

namespace tone { enum : uint32_t { off = 0, low = 1, high = 2 }; }

// Move a servo to an absolute position. (to robot)
struct SetServoPosition {
  static constexpr uint8_t TYPE = 0x00;
  static constexpr uint8_t SIZE = 3;
  uint8_t servo_id;  // servo number
  uint8_t position_deg;  // degrees
};

inline bool valid(const SetServoPosition& message) {
  return message.servo_id == 0 && message.position_deg <= 180;
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

// Let both wheels turn; negative is backward. (to robot)
struct SetWheelSpeeds {
  static constexpr uint8_t TYPE = 0x10;
  static constexpr uint8_t SIZE = 5;
  int16_t left_mm_per_s;  // mm/s
  int16_t right_mm_per_s;  // mm/s
};

inline bool valid(const SetWheelSpeeds& message) {
  return message.left_mm_per_s >= -800 && message.left_mm_per_s <= 800 && message.right_mm_per_s >= -800 && message.right_mm_per_s <= 800;
}

inline uint8_t pack(const SetWheelSpeeds& message, uint8_t* out) {
  out[0] = 0x10;
  put16(out + 1, static_cast<uint16_t>(message.left_mm_per_s));
  put16(out + 3, static_cast<uint16_t>(message.right_mm_per_s));
  return 5;
}

inline bool unpack(const uint8_t* in, uint8_t size, SetWheelSpeeds& message) {
  if (size < 5 || in[0] != 0x10) {
    return false;
  }
  message.left_mm_per_s = static_cast<int16_t>(get16(in + 1));
  message.right_mm_per_s = static_cast<int16_t>(get16(in + 3));
  return true;
}

// Switch the lamp. (to robot)
struct SetLamp {
  static constexpr uint8_t TYPE = 0x11;
  static constexpr uint8_t SIZE = 2;
  bool on;  // 0 off, 1 on
};

inline bool valid(const SetLamp& /* message */) {
  return true;
}

inline uint8_t pack(const SetLamp& message, uint8_t* out) {
  out[0] = 0x11;
  out[1] = message.on ? 1 : 0;
  return 2;
}

inline bool unpack(const uint8_t* in, uint8_t size, SetLamp& message) {
  if (size < 2 || in[0] != 0x11) {
    return false;
  }
  message.on = in[1] != 0;
  return true;
}

// Sound a tone for a while. Not a set-point: each one is sent once, in order. (to robot)
struct Beep {
  static constexpr uint8_t TYPE = 0x12;
  static constexpr uint8_t SIZE = 4;
  uint8_t tone;  // tone
  uint16_t duration_ms;  // milliseconds
};

inline bool valid(const Beep& message) {
  return (message.tone == 0 || message.tone == 1 || message.tone == 2) && message.duration_ms <= 5000;
}

inline uint8_t pack(const Beep& message, uint8_t* out) {
  out[0] = 0x12;
  out[1] = message.tone;
  put16(out + 2, message.duration_ms);
  return 4;
}

inline bool unpack(const uint8_t* in, uint8_t size, Beep& message) {
  if (size < 4 || in[0] != 0x12) {
    return false;
  }
  message.tone = in[1];
  message.duration_ms = get16(in + 2);
  return true;
}

// The gains of the wheels' speed control. (to robot)
struct SetPidGains {
  static constexpr uint8_t TYPE = 0x13;
  static constexpr uint8_t SIZE = 9;
  float proportional;  // PWM per mm/s
  float integral;  // PWM per mm
};

inline bool valid(const SetPidGains& message) {
  return message.proportional >= 0.0F && message.proportional <= 100.0F && message.integral >= 0.0F && message.integral <= 100.0F;
}

inline uint8_t pack(const SetPidGains& message, uint8_t* out) {
  out[0] = 0x13;
  put_float(out + 1, message.proportional);
  put_float(out + 5, message.integral);
  return 9;
}

inline bool unpack(const uint8_t* in, uint8_t size, SetPidGains& message) {
  if (size < 9 || in[0] != 0x13) {
    return false;
  }
  message.proportional = get_float(in + 1);
  message.integral = get_float(in + 5);
  return true;
}

// How far each wheel has turned since the robot was switched on, and when that was so. (from robot)
struct Odometry {
  static constexpr uint8_t TYPE = 0x10;
  static constexpr uint8_t SIZE = 13;
  uint32_t time_ms;  // milliseconds since the robot was switched on
  int32_t left_ticks;  // encoder ticks
  int32_t right_ticks;  // encoder ticks
};

inline bool valid(const Odometry& /* message */) {
  return true;
}

inline uint8_t pack(const Odometry& message, uint8_t* out) {
  out[0] = 0x10;
  put32(out + 1, message.time_ms);
  put32(out + 5, static_cast<uint32_t>(message.left_ticks));
  put32(out + 9, static_cast<uint32_t>(message.right_ticks));
  return 13;
}

inline bool unpack(const uint8_t* in, uint8_t size, Odometry& message) {
  if (size < 13 || in[0] != 0x10) {
    return false;
  }
  message.time_ms = get32(in + 1);
  message.left_ticks = static_cast<int32_t>(get32(in + 5));
  message.right_ticks = static_cast<int32_t>(get32(in + 9));
  return true;
}

// How the robot is. (from robot)
struct Status {
  static constexpr uint8_t TYPE = 0x11;
  static constexpr uint8_t SIZE = 7;
  uint8_t state;  // state
  float battery_v;  // volts
  bool bumper;  // 0 free, 1 touched
};

inline bool valid(const Status& message) {
  return (message.state == 0 || message.state == 1 || message.state == 2 || message.state == 9) && message.battery_v >= 0.0F && message.battery_v <= 30.0F;
}

inline uint8_t pack(const Status& message, uint8_t* out) {
  out[0] = 0x11;
  out[1] = message.state;
  put_float(out + 2, message.battery_v);
  out[6] = message.bumper ? 1 : 0;
  return 7;
}

inline bool unpack(const uint8_t* in, uint8_t size, Status& message) {
  if (size < 7 || in[0] != 0x11) {
    return false;
  }
  message.state = in[1];
  message.battery_v = get_float(in + 2);
  message.bumper = in[6] != 0;
  return true;
}

// What the distance sensor sees. (from robot)
struct Distance {
  static constexpr uint8_t TYPE = 0x12;
  static constexpr uint8_t SIZE = 5;
  int16_t bearing_deg;  // degrees, clockwise, 0 ahead
  uint16_t distance_mm;  // mm; 65535 nothing in sight
};

inline bool valid(const Distance& message) {
  return message.bearing_deg >= -180 && message.bearing_deg <= 180;
}

inline uint8_t pack(const Distance& message, uint8_t* out) {
  out[0] = 0x12;
  put16(out + 1, static_cast<uint16_t>(message.bearing_deg));
  put16(out + 3, message.distance_mm);
  return 5;
}

inline bool unpack(const uint8_t* in, uint8_t size, Distance& message) {
  if (size < 5 || in[0] != 0x12) {
    return false;
  }
  message.bearing_deg = static_cast<int16_t>(get16(in + 1));
  message.distance_mm = get16(in + 3);
  return true;
}

// Type and fields of a message to robot; 0 for an unknown type.
inline uint8_t command_size(uint8_t type) {
  switch (type) {
    case 0x00: return SetServoPosition::SIZE;
    case 0x10: return SetWheelSpeeds::SIZE;
    case 0x11: return SetLamp::SIZE;
    case 0x12: return Beep::SIZE;
    case 0x13: return SetPidGains::SIZE;
    default: return 0;
  }
}

// Type and fields of a message from robot; 0 for an unknown type.
inline uint8_t telemetry_size(uint8_t type) {
  switch (type) {
    case 0x10: return Odometry::SIZE;
    case 0x11: return Status::SIZE;
    case 0x12: return Distance::SIZE;
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
      case 0x10: return hand_over<SetWheelSpeeds>(in, handler);
      case 0x11: return hand_over<SetLamp>(in, handler);
      case 0x12: return hand_over<Beep>(in, handler);
      case 0x13: return hand_over<SetPidGains>(in, handler);
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

}  // namespace frame_telemetry

#endif  // TURTLEWIRE_FRAME_TELEMETRY_H
