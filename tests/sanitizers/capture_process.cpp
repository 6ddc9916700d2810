// colift-kinect and colift-openni2 under AddressSanitizer: they end as without. A driver reads how its
// process ended, and when, from its exit: a report in place of signal 11, or a leak check of a second at the
// end, would be another ending.

extern "C" const char* __asan_default_options() {
  return "handle_segv=0:detect_leaks=0";
}
