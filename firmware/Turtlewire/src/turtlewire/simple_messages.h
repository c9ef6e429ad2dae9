// The messages of simple. Made from spec/protocols/simple.toml by `make generate`: do not edit.
#ifndef TURTLEWIRE_SIMPLE_MESSAGES_H
#define TURTLEWIRE_SIMPLE_MESSAGES_H

#include <stdint.h>

namespace turtlewire {
namespace simple {

const uint32_t BAUD = 9600UL;  // S6
const uint8_t LENGTH = 7;
const uint8_t MAX_WINDOW = 8;  // S9

const uint8_t DRIVE_FORWARD = 'F';  // Drive forward until told otherwise.
const uint8_t DRIVE_BACKWARD = 'B';  // Drive backward until told otherwise. The source's text repeats forward's: a copy slip (S1).
const uint8_t STEER_LEFT = 'L';  // Turn the front wheels left.
const uint8_t STEER_RIGHT = 'R';  // Turn the front wheels right.
const uint8_t STOP = 'S';  // Stop the motors: drive and steering are 0 then, headlights stay as they are (S5).
const uint8_t HEADLIGHTS = 'H';  // Switch all four headlights.

const uint8_t ACCEPTED = 'K';  // The seven bytes were a valid command, and it is carried out (S4).
const uint8_t REJECTED = 'F';  // The seven bytes were no valid command, and nothing has changed (S4).

// How the six positions of a command are filled.
enum Form : uint8_t {
  FORM_UNKNOWN,
  FORM_EMPTY,   // nothing but don't-care positions
  FORM_NUMBER,  // three digits, 000..255
  FORM_BITS,    // four digits: 0 off, any other on
};

inline Form form_of(uint8_t letter) {
  switch (letter) {
    case DRIVE_FORWARD: return FORM_NUMBER;
    case DRIVE_BACKWARD: return FORM_NUMBER;
    case STEER_LEFT: return FORM_NUMBER;
    case STEER_RIGHT: return FORM_NUMBER;
    case STOP: return FORM_EMPTY;
    case HEADLIGHTS: return FORM_BITS;
    default: return FORM_UNKNOWN;
  }
}

}  // namespace simple
}  // namespace turtlewire

#endif  // TURTLEWIRE_SIMPLE_MESSAGES_H
