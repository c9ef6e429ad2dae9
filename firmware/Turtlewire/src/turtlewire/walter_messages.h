// The messages of walter. Made from spec/protocols/walter.toml by `make generate`: do not edit.
#ifndef TURTLEWIRE_WALTER_MESSAGES_H
#define TURTLEWIRE_WALTER_MESSAGES_H

#include <stdint.h>

namespace turtlewire {
namespace walter {

const uint32_t BAUD = 9600UL;  // W16
const uint8_t QUEUE_COMMANDS = 16;  // what a host may have sent ahead (W9)
const uint8_t DEFAULT_SPEED = 100;
const uint8_t MAX_ARGUMENTS = 4;

enum Id : uint8_t {
  // Logo control.
  EMPTY_LINE,
  SELECT_DIRECT,  // Change to direct control. Abandons queued motion at once (W8).
  FORWARD,  // Move forward.
  BACK,  // Move back.
  SET_SPEED,  // Set the speed of moves and turns.
  LEFT,  // Turn left.
  RIGHT,  // Turn right.
  PEN_UP,  // Lift the pen.
  PEN_DOWN,  // Lower the pen.
  HORN_OFF,  // Horn off. The source swaps HORNHI and HORNOFF in its third column; the bytes rule (W3).
  HORN_LOW,  // Horn, low pitch.
  HORN_HIGH,  // Horn, high pitch (W3).
  LAMP_ON,  // Lamp on.
  LAMP_OFF,  // Lamp off.
  RESET_LOCATION,  // Here is X = 0, Y = 0; the heading stays.
  GO_HOME,  // Move to X = 0, Y = 0. Does not promise heading 0 (W10).
  TURN_TO,  // Turn to an absolute heading.
  GO_TO,  // Move to an absolute position; keeps the heading (W10).
  GO_TO_X,  // Move to an absolute X; keeps Y and the heading (W10).
  GO_TO_Y,  // Move to an absolute Y; keeps X and the heading (W10).
  QUERY_TOWARDS,  // Ask for the bearing of a point.
  QUERY_HEADING,  // Ask for the heading.
  QUERY_LOCATION,  // Ask for the location.
  QUERY_X,  // Ask for the X coordinate.
  QUERY_Y,  // Ask for the Y coordinate.
  QUERY_PEN,  // Ask whether the pen is down.
  // Direct control.
  STOP,  // Immediate stop.
  SELECT_LOGO,  // Change to Logo control. Direct motion stops.
  START_FORWARD,  // Start moving forward.
  START_BACKWARD,  // Start moving backward.
  MOVE_FASTER,  // Linear speed up by one unit; saturates at 255 (W14).
  MOVE_SLOWER,  // Linear speed down by one unit; saturates at 0 (W14).
  TURN_FASTER,  // Turning speed up by one unit; saturates at 255 (W14).
  TURN_SLOWER,  // Turning speed down by one unit; saturates at 0 (W14).
  RAISE_PEN,  // Pen up.
  LOWER_PEN,  // Pen down.
  SET_MOVE_SPEED,  // Set the linear speed.
  SET_TURN_SPEED,  // Set the turning speed.
  START_LEFT,  // Start turning left.
  START_RIGHT,  // Start turning right.
};

inline bool is_key(Id id) { return id >= STOP; }

// A message, and how many bytes of arguments follow its letters.
struct Form {
  Id id;
  uint8_t size;
};

// The command that begins with these letters, the second 0 if there is none; false: none does.
inline bool find_line(uint8_t first, uint8_t second, Form& form) {
  switch ((static_cast<uint16_t>(first) << 8U) | second) {
    case 0x3200: form = {SELECT_DIRECT, 0}; return true;
    case 0x4600: form = {FORWARD, 2}; return true;
    case 0x4200: form = {BACK, 2}; return true;
    case 0x5600: form = {SET_SPEED, 1}; return true;
    case 0x4C00: form = {LEFT, 2}; return true;
    case 0x5200: form = {RIGHT, 2}; return true;
    case 0x5055: form = {PEN_UP, 0}; return true;
    case 0x5044: form = {PEN_DOWN, 0}; return true;
    case 0x4830: form = {HORN_OFF, 0}; return true;
    case 0x484C: form = {HORN_LOW, 0}; return true;
    case 0x4848: form = {HORN_HIGH, 0}; return true;
    case 0x4531: form = {LAMP_ON, 0}; return true;
    case 0x4530: form = {LAMP_OFF, 0}; return true;
    case 0x4352: form = {RESET_LOCATION, 0}; return true;
    case 0x4330: form = {GO_HOME, 0}; return true;
    case 0x4348: form = {TURN_TO, 2}; return true;
    case 0x434C: form = {GO_TO, 4}; return true;
    case 0x4358: form = {GO_TO_X, 2}; return true;
    case 0x4359: form = {GO_TO_Y, 2}; return true;
    case 0x5154: form = {QUERY_TOWARDS, 4}; return true;
    case 0x5148: form = {QUERY_HEADING, 0}; return true;
    case 0x514C: form = {QUERY_LOCATION, 0}; return true;
    case 0x5158: form = {QUERY_X, 0}; return true;
    case 0x5159: form = {QUERY_Y, 0}; return true;
    case 0x5150: form = {QUERY_PEN, 0}; return true;
    default: return false;
  }
}

// Whether a second letter has to follow.
inline bool is_prefix(uint8_t letter) {
  return letter == 'C' || letter == 'E' || letter == 'H' || letter == 'P' || letter == 'Q';
}

inline bool find_key(uint8_t key, Form& form) {
  switch (key) {
    case ' ': form = {STOP, 0}; return true;
    case '1': form = {SELECT_LOGO, 0}; return true;
    case 'A': form = {START_FORWARD, 0}; return true;
    case 'Z': form = {START_BACKWARD, 0}; return true;
    case 'D': form = {MOVE_FASTER, 0}; return true;
    case 'C': form = {MOVE_SLOWER, 0}; return true;
    case 'F': form = {TURN_FASTER, 0}; return true;
    case 'V': form = {TURN_SLOWER, 0}; return true;
    case 'S': form = {RAISE_PEN, 0}; return true;
    case 'X': form = {LOWER_PEN, 0}; return true;
    case 'G': form = {SET_MOVE_SPEED, 1}; return true;
    case 'B': form = {SET_TURN_SPEED, 1}; return true;
    case ',': form = {START_LEFT, 0}; return true;
    case '.': form = {START_RIGHT, 0}; return true;
    default: return false;
  }
}

}  // namespace walter
}  // namespace turtlewire

#endif  // TURTLEWIRE_WALTER_MESSAGES_H
