#include "walter.h"

namespace turtlewire {
namespace walter {

namespace {

const uint8_t CR = 0x0D;
const uint8_t LF = 0x0A;
// A dropped line counts once for every so many bytes: it may never end.
const uint8_t MAX_RAW = 64;

// W2: letters in either case, and nothing else.
uint8_t upper(uint8_t byte) { return byte >= 'a' && byte <= 'z' ? static_cast<uint8_t>(byte - ('a' - 'A')) : byte; }

uint8_t group_bit(uint8_t letter) {
  switch (letter) {
    case 'C': return GROUP_C;
    case 'Q': return GROUP_Q;
    case 'H': return GROUP_H;
    case 'E': return GROUP_E;
    default: return 0;
  }
}

uint8_t end_line(uint8_t size, uint8_t* out) {
  out[size] = CR;
  return static_cast<uint8_t>(size + 1U);
}

}  // namespace

void Parser::reset() {
  state_ = LETTERS;
  count_ = 0;
  taken_ = 0;
}

Parser::Result Parser::receive(uint8_t byte) {
  if (may_skip_lf_) {  // W1
    may_skip_lf_ = false;
    if (byte == LF) {
      return NOTHING;
    }
  }
  ++count_;
  return mode_ == LOGO ? line_byte(byte) : key_byte(byte);
}

Parser::Result Parser::line_byte(uint8_t byte) {
  switch (state_) {
    case LETTERS: return letter(byte);
    case ARGUMENTS: argument(byte); return NOTHING;
    case RET:
      if (byte == CR) {
        return complete(message_.id, true);
      }
      state_ = DROPPING;  // not drop(): what stands where RET must be is never RET
      return NOTHING;
    default: return drop(byte);
  }
}

Parser::Result Parser::letter(uint8_t byte) {
  if (byte == CR && count_ == 1) {
    return complete(EMPTY_LINE, true);
  }
  const uint8_t shown = upper(byte);
  const uint8_t first = count_ == 1 ? shown : first_;
  const uint8_t second = count_ == 1 ? 0 : shown;
  const uint8_t group = group_bit(first);
  Form form = {EMPTY_LINE, 0};
  if (group != 0 && (group & groups_) == 0) {
    return drop(byte);
  }
  if (find_line(first, second, form)) {
    message_.id = form.id;
    size_ = form.size;
    state_ = size_ == 0 ? RET : ARGUMENTS;
    return NOTHING;
  }
  if (count_ == 1 && is_prefix(first)) {
    first_ = first;
    return NOTHING;
  }
  return drop(byte);
}

void Parser::argument(uint8_t byte) {
  message_.arguments[taken_] = byte;
  ++taken_;
  if (taken_ == size_) {
    state_ = RET;
  }
}

// W6: up to its RET, which may be the wrong byte itself.
Parser::Result Parser::drop(uint8_t byte) {
  state_ = DROPPING;
  if (byte == CR) {
    reset();
    may_skip_lf_ = true;
    return MALFORMED;
  }
  if (count_ < MAX_RAW) {
    return NOTHING;
  }
  count_ = 0;
  return MALFORMED;
}

Parser::Result Parser::key_byte(uint8_t byte) {
  if (state_ == ARGUMENTS) {
    message_.arguments[0] = byte;
    return complete(message_.id, false);
  }
  Form form = {EMPTY_LINE, 0};
  if (find_key(upper(byte), form)) {
    if (form.size == 0) {
      return complete(form.id, false);
    }
    message_.id = form.id;
    state_ = ARGUMENTS;
    return NOTHING;
  }
  if (byte == CR) {
    return complete(EMPTY_LINE, true);  // no key, but a sign of life (section 4)
  }
  reset();
  return MALFORMED;
}

Parser::Result Parser::complete(Id id, bool ret) {
  reset();
  may_skip_lf_ = ret;
  message_.id = id;
  if (id == SELECT_DIRECT) {
    mode_ = DIRECT;
  } else if (id == SELECT_LOGO) {
    mode_ = LOGO;
  }
  return MESSAGE;
}

uint8_t reply_u16(uint8_t letter, uint16_t value, uint8_t* out) {
  out[0] = 'Q';
  out[1] = letter;
  out[2] = static_cast<uint8_t>(value >> 8U);
  out[3] = static_cast<uint8_t>(value & 0xFFU);
  return end_line(4, out);
}

uint8_t reply_location(int16_t x, int16_t y, uint8_t* out) {
  reply_u16('L', static_cast<uint16_t>(x), out);
  out[4] = static_cast<uint8_t>(static_cast<uint16_t>(y) >> 8U);
  out[5] = static_cast<uint8_t>(static_cast<uint16_t>(y) & 0xFFU);
  return end_line(6, out);
}

uint8_t reply_pen(bool down, uint8_t* out) {
  out[0] = 'Q';
  out[1] = 'P';
  out[2] = down ? 1 : 0;
  return end_line(3, out);
}

uint8_t limit_event(uint8_t side, uint8_t* out) {
  out[0] = 'L';
  out[1] = side;
  return end_line(2, out);
}

}  // namespace walter
}  // namespace turtlewire
