// Two stepper motors and a servo, by timer 1 of an AVR (ATmega328P, ATmega2560): for sketches that never wait.
//
// Both motors always make their steps together; only their directions differ: that drives a robot on two wheels straight
// or turns it on the spot. Include this once, in the sketch: it has the interrupts. Pins 9 and 10 of an Uno lose their
// PWM.
#ifndef TURTLEWIRE_AVR_STEPPER_PAIR_H
#define TURTLEWIRE_AVR_STEPPER_PAIR_H

#include <Arduino.h>
#include <util/atomic.h>

namespace turtlewire {
namespace avr {

const uint32_t TICKS_PER_S = F_CPU / 8;
const uint32_t TICKS_PER_US = TICKS_PER_S / 1000000UL;
const uint32_t SERVO_PERIOD_TICKS = TICKS_PER_S / 50;
// A compare register reaches 65535 ticks; longer pauses go by pieces of this.
const uint32_t PIECE_TICKS = 0x8000;
const uint32_t FOREVER = 0xFFFFFFFF;

// A pin, found once: digitalWrite is too slow for an interrupt.
class Pin {
 public:
  void begin(uint8_t number) {
    pinMode(number, OUTPUT);
    out_ = portOutputRegister(digitalPinToPort(number));
    mask_ = digitalPinToBitMask(number);
  }
  // Only with interrupts off, as a port is shared.
  void set(bool high) { *out_ = static_cast<uint8_t>(high ? *out_ | mask_ : *out_ & ~mask_); }

 private:
  volatile uint8_t* out_ = nullptr;
  uint8_t mask_ = 0;
};

class StepperPair {
 public:
  void begin(uint8_t left_step, uint8_t right_step, uint8_t left_direction, uint8_t right_direction, uint8_t servo) {
    left_step_.begin(left_step);
    right_step_.begin(right_step);
    left_direction_.begin(left_direction);
    right_direction_.begin(right_direction);
    servo_.begin(servo);
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
      TCCR1A = 0;
      TCCR1B = _BV(CS11);  // counts through, F_CPU / 8
      OCR1B = static_cast<uint16_t>(TCNT1 + 1000);
      TIFR1 = _BV(OCF1B);
      TIMSK1 = _BV(OCIE1B);
    }
  }

  // Begins to make steps: so many (FOREVER: until stop), with so many ticks (>= 100) from one to the next; 0: none.
  void start(bool left_ahead, bool right_ahead, uint32_t steps, uint32_t ticks) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
      left_direction_.set(left_ahead);
      right_direction_.set(right_ahead);
      to_do_ = steps;
      done_ = 0;
      pace(ticks);
    }
  }

  // From now on, with so many ticks from one step to the next; 0: they pause.
  void set_pace(uint32_t ticks) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { pace(ticks); }
  }

  // Makes no more steps.
  void stop() {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
      to_do_ = 0;
      TIMSK1 &= static_cast<uint8_t>(~_BV(OCIE1A));
    }
  }

  bool is_done() const {
    bool is_none_left = false;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { is_none_left = to_do_ == 0; }
    return is_none_left;
  }

  // The steps made since start.
  uint32_t done() const {
    uint32_t steps = 0;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { steps = done_; }
    return steps;
  }

  // Where the servo goes: the width of its pulses, 500..2500 us.
  void set_servo(uint16_t width_us) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { pulse_ticks_ = static_cast<uint16_t>(width_us * TICKS_PER_US); }
  }

  // For the interrupts.
  void on_step() {
    if (wait_ticks_ != 0) {
      go_on();
      return;
    }
    left_step_.set(true);
    right_step_.set(true);
    ++done_;
    if (to_do_ != FOREVER && --to_do_ == 0) {
      TIMSK1 &= static_cast<uint8_t>(~_BV(OCIE1A));
    }
    next();
    left_step_.set(false);  // what is between is longer than the microsecond that drivers want
    right_step_.set(false);
  }

  void on_servo() {
    is_pulse_ = !is_pulse_;
    servo_.set(is_pulse_);
    OCR1B = static_cast<uint16_t>(OCR1B + (is_pulse_ ? pulse_ticks_ : SERVO_PERIOD_TICKS - pulse_ticks_));
  }

 private:
  void pace(uint32_t ticks) {
    pace_ticks_ = ticks;
    TIMSK1 &= static_cast<uint8_t>(~_BV(OCIE1A));
    if (ticks != 0 && to_do_ != 0) {
      OCR1A = TCNT1;
      next();
      TIFR1 = _BV(OCF1A);
      TIMSK1 |= _BV(OCIE1A);
    }
  }

  void next() {
    wait_ticks_ = pace_ticks_;
    go_on();
  }

  // The next piece of a pause: at most one and a half pieces, so that none is too short to be set in time.
  void go_on() {
    const uint32_t piece = wait_ticks_ > PIECE_TICKS + PIECE_TICKS / 2 ? PIECE_TICKS : wait_ticks_;
    wait_ticks_ -= piece;
    OCR1A = static_cast<uint16_t>(OCR1A + piece);
  }

  Pin left_step_, right_step_, left_direction_, right_direction_, servo_;
  volatile uint32_t to_do_ = 0;
  volatile uint32_t done_ = 0;
  uint32_t pace_ticks_ = 0;
  uint32_t wait_ticks_ = 0;
  uint16_t pulse_ticks_ = 3000;
  bool is_pulse_ = false;
};

}  // namespace avr
}  // namespace turtlewire

// The one pair of this sketch.
turtlewire::avr::StepperPair steppers;

ISR(TIMER1_COMPA_vect) { steppers.on_step(); }
ISR(TIMER1_COMPB_vect) { steppers.on_servo(); }

#endif  // TURTLEWIRE_AVR_STEPPER_PAIR_H
