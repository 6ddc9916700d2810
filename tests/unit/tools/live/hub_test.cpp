#include "tools/live/hub.hpp"

#include <catch2/catch.hpp>
#include <list>

using namespace colift::live;

namespace {

struct Silent final : Caller {
  explicit Silent(Hub& hub) : hub_(hub) { hub_.call(this); }
  ~Silent() override { hub_.hang_up(this); }
  void turn_out() override { ++turned_out; }
  int turned_out = 0;

 private:
  Hub& hub_;
};

ServerConfig small() {
  ServerConfig config;
  config.most_callers = 4;
  config.most_clients = 3;
  config.operator_places = 2;
  return config;
}

}  // namespace

TEST_CASE("connections that say nothing lock nobody out: the longest idle makes room") {
  Hub hub(small(), PageFiles("/nowhere"));
  std::list<Silent> callers;
  for (int i = 0; i < 40; ++i) callers.emplace_back(hub);
  int index = 0;
  for (const Silent& caller : callers) {
    INFO(index);
    CHECK(caller.turned_out == (index < 36 ? 1 : 0));
    ++index;
  }
  CHECK(hub.turned_away == 36);
}

TEST_CASE("who has just asked for something is not the one who leaves") {
  Hub hub(small(), PageFiles("/nowhere"));
  std::list<Silent> callers;
  for (int i = 0; i < 4; ++i) callers.emplace_back(hub);
  hub.renew(&callers.front());
  Silent newcomer(hub);
  auto it = callers.begin();
  CHECK(it->turned_out == 0);
  CHECK((++it)->turned_out == 1);
  // nor is a place needed where one has been given back
  callers.pop_back();
  Silent another(hub);
  CHECK(std::next(callers.begin(), 2)->turned_out == 0);
}

TEST_CASE("watchers take all places but the operator's") {
  Hub hub(small(), PageFiles("/nowhere"));
  for (int i = 0; i < 3; ++i) {
    CHECK(hub.has_place(false));
    hub.take_place();
  }
  CHECK_FALSE(hub.has_place(false));
  for (int i = 0; i < 2; ++i) {
    CHECK(hub.has_place(true));
    hub.take_place();
  }
  CHECK_FALSE(hub.has_place(true));
  for (int i = 0; i < 3; ++i) hub.leave_place();
  CHECK(hub.has_place(false));
}
