// All of the core in one file, every member of every template: for compilers and for tools that look at the source.
// No robot and no PC runs it.
#include "../../src/Turtlewire.h"

namespace {

struct Handler {
  void drive(int16_t /* pwm */) {}
  void steer(int16_t /* pwm */) {}
  void headlights(bool /* left_upper */, bool /* left_lower */, bool /* right_upper */, bool /* right_lower */) {}
  void extension(const turtlewire::simple::Parser& /* command */) {}
  void key(const turtlewire::walter::Message& /* message */) {}
  void go_direct() {}
  void heard() {}
  template <class Message>
  void message(const Message& /* message */) {}
};

}  // namespace

template class turtlewire::simple::Robot<Handler>;
template class turtlewire::walter::Robot<Handler>;
template class turtlewire::frame::Robot<frame_0_1::Dialect, Handler>;
template class turtlewire::frame::Robot<frame_0_1_literal::Dialect, Handler>;
template class turtlewire::frame::Robot<frame_telemetry::Dialect, Handler>;
template class turtlewire::frame::Sender<frame_0_1::Dialect>;
template class turtlewire::frame::Sender<frame_0_1_literal::Dialect>;
template class turtlewire::frame::Sender<frame_telemetry::Dialect>;
