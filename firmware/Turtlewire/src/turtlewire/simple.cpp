#include "simple.h"

namespace turtlewire {
namespace simple {

bool are_digits(const uint8_t* text, uint8_t count) {
  for (uint8_t at = 0; at < count; ++at) {
    if (text[at] < '0' || text[at] > '9') {
      return false;
    }
  }
  return true;
}

uint8_t Parser::receive(uint8_t byte) {
  command_[count_] = byte;
  ++count_;
  if (count_ < LENGTH) {
    return 0;
  }
  count_ = 0;
  return valid() ? ACCEPTED : REJECTED;
}

uint16_t Parser::number(uint8_t position) const {
  uint16_t value = 0;
  for (uint8_t at = position; at < position + 3; ++at) {
    const auto digit = static_cast<uint8_t>(command_[at] - '0');
    value = static_cast<uint16_t>(value * 10U + digit);
  }
  return value;
}

// S3: three digits of at most 255, or four digits; any byte where the source has "-" (S2).
bool Parser::valid() const {
  switch (form_of(command_[0])) {
    case FORM_EMPTY: return true;
    case FORM_NUMBER: return are_digits(command_ + 1, 3) && number(1) <= UINT8_MAX;
    case FORM_BITS: return are_digits(command_ + 1, 4);
    default: return extension_ != nullptr && extension_(command_);
  }
}

}  // namespace simple
}  // namespace turtlewire
