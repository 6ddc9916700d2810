// A peer in a process of its own.
//   dds_peer read DOMAIN TOPIC TYPE     reads reliably, until it is killed
//   dds_peer flood DOMAIN TOPIC TYPE    writes garbage as fast as it goes
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/dds/fast_peer.hpp"

int main(int argc, char** argv) {
  using namespace std::chrono_literals;
  if (argc != 5) return 2;
  const std::string mode = argv[1];
  colift::tests::FastPeer peer(std::atoi(argv[2]));
  if (mode == "read") {
    const auto reader = peer.reader(argv[3], argv[4]);
    for (;;) (void)reader->next(1000ms);
  }
  const auto writer = peer.writer(argv[3], argv[4], {true, false, 5});
  colift::tests::Bytes garbage(2000, 0xff);
  garbage[0] = 0, garbage[1] = 1, garbage[2] = 0, garbage[3] = 0;
  for (unsigned i = 0;; ++i) {
    garbage[4 + i % 1900] ^= static_cast<unsigned char>(i);
    (void)writer->write(garbage);
  }
}
