#include "tools/live/visitor.hpp"

#include <catch2/catch.hpp>

using namespace colift::live;

TEST_CASE("programs and our own page come in; pages from elsewhere do not") {
  DoorRules rules;
  CHECK_FALSE(turned_away({"127.0.0.1:8765", {}, "/"}, rules));
  CHECK_FALSE(turned_away({"localhost:8765", "http://localhost:8765", "/"}, rules));
  CHECK_FALSE(turned_away({"[::1]:8765", "http://[::1]:8765", "/"}, rules));
  CHECK(turned_away({"localhost:8765", "http://localhost:9999", "/"}, rules));
  CHECK(turned_away({"localhost:8765", "https://elsewhere.example", "/"}, rules));
  CHECK(turned_away({"localhost:8765", "null", "/"}, rules));
  CHECK(turned_away({"", {}, "/"}, rules));
  rules.origins.push_back("https://elsewhere.example");
  CHECK_FALSE(turned_away({"localhost:8765", "https://elsewhere.example", "/"}, rules));
}

TEST_CASE("only a page that was allowed may read what is served") {
  DoorRules rules;
  rules.origins.push_back("https://viewer.example");
  CHECK(shared_with({"127.0.0.1:8765", "https://viewer.example", "/robot.urdf"}, rules) ==
        "https://viewer.example");
  CHECK_FALSE(shared_with({"127.0.0.1:8765", "https://viewer.example.org", "/robot.urdf"}, rules));
  CHECK_FALSE(shared_with({"127.0.0.1:8765", "null", "/robot.urdf"}, rules));
  CHECK_FALSE(shared_with({"127.0.0.1:8765", {}, "/robot.urdf"}, rules));
}

TEST_CASE("a name that was bent to the loopback address is refused") {
  DoorRules rules;
  CHECK(turned_away({"evil.example:8765", "http://evil.example:8765", "/"}, rules));
  CHECK(turned_away({"evil.example", {}, "/"}, rules));
  CHECK(turned_away({"localhost.evil.example:8765", {}, "/"}, rules));
}

TEST_CASE("opened to a network, the machine's own names and addresses count, and no other name") {
  DoorRules rules;
  rules.hosts = {"robot.lab", "robot"};
  for (const char* host :
       {"robot.lab:8765", "ROBOT.lab:8765", "robot", "192.168.1.7:8765", "[fe80::1]:8765"}) {
    INFO(host);
    CHECK_FALSE(turned_away({host, std::string("http://") + host, "/"}, rules));
  }
  for (const char* host :
       {"evil.example:8765", "robot.lab.evil.example", "robo", "robot.la", "xrobot", "["}) {
    INFO(host);
    CHECK(turned_away({host, {}, "/"}, rules));
  }
}

TEST_CASE("the operator's token has to be right, and there") {
  DoorRules rules;
  CHECK_FALSE(has_token("/?token=", rules));
  rules.token = "a1b2";
  CHECK(has_token("/?token=a1b2", rules));
  CHECK(has_token("/?x=1&token=a1b2&y", rules));
  for (const char* target : {"/", "/?", "/?token=", "/?token=a1b", "/?token=a1b3", "/?token=a1b22",
                             "/?xtoken=a1b2", "/token=a1b2"}) {
    INFO(target);
    CHECK_FALSE(has_token(target, rules));
  }
}

TEST_CASE("a client may say much at once, but not for long") {
  TalkLimit limit(10.0, 40.0);
  for (int i = 0; i < 40; ++i) CHECK(limit.take(100.0));
  CHECK_FALSE(limit.take(100.0));
  CHECK(limit.take(100.5));
  for (int i = 0; i < 4; ++i) CHECK(limit.take(100.5));
  CHECK_FALSE(limit.take(100.5));
}
