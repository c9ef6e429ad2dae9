// Turtlewire: the robot's end of three serial protocols. Take what the robot speaks:
//
//   turtlewire::simple::Robot    an Arduino car, seven characters a command, answered K or F
//   turtlewire::frame::Robot     A3-framed binary messages with a CRC-8, of a dialect
//   turtlewire::walter::Robot    the WALTER floor turtle
#ifndef TURTLEWIRE_H
#define TURTLEWIRE_H

#include "turtlewire/frame.h"
#include "turtlewire/frame_0_1.h"
#include "turtlewire/frame_0_1_literal.h"
#include "turtlewire/frame_telemetry.h"
#include "turtlewire/simple.h"
#include "turtlewire/walter.h"

#endif  // TURTLEWIRE_H
