#include "hal/drivers/v4l2_camera/video_stream.hpp"

#include <linux/videodev2.h>

#include <catch2/catch.hpp>
#include <cerrno>

#include "hal/drivers/v4l2_camera/video_words.hpp"
#include "tests/support/video_rig.hpp"

// The stream over an emulated device in virtual time: nothing waits, nothing depends on the machine.
namespace colift::hal::v4l2 {
namespace {

using namespace std::chrono_literals;
using Lie = sim_hal::EmulatedVideo::Lie;

struct Far {
  ManualClock clock;
  V4l2CameraConfig config;
  sim_hal::EmulatedVideo device;

  explicit Far(const std::vector<std::string>& faults = {}, std::size_t padding = 0)
      : device(device_config(faults, padding), tests::box_source(clock, std::nullopt), clock,
               [this](Duration d) { clock.advance(d); }) {}

  static sim_hal::EmulatedVideoConfig device_config(const std::vector<std::string>& faults,
                                                    std::size_t padding) {
    auto c = tests::video_device(faults);
    c.padding = padding;
    return c;
  }

  Result<std::unique_ptr<VideoStream>> open(int width = 160, int height = 120) {
    return VideoStream::open(device, config, width, height);
  }
  void check_left_clean() {
    const auto report = device.report();
    CHECK(report.descriptors == 0);
    CHECK(report.mapped == 0);
    CHECK(report.broken_rules == std::vector<std::string>{});
  }
};

template <class Structure>
Structure& as(void* argument) {
  return *static_cast<Structure*>(argument);
}

/// Changes what one request answers.
template <class Structure, class Change>
Lie of(unsigned long wanted, const Change& change) {
  return [=](unsigned long request, void* argument) -> std::optional<int> {
    if (request == wanted) change(as<Structure>(argument));
    return std::nullopt;
  };
}

Lie fails(unsigned long wanted, int error_number) {
  return [=](unsigned long request, void*) -> std::optional<int> {
    if (request == wanted) return -error_number;
    return std::nullopt;
  };
}

struct Case {
  const char* name;
  Lie lie;
  ErrorCode code;
  const char* expected;
};

}  // namespace

TEST_CASE("pictures of a device that tells the truth", "[v4l2]") {
  const std::size_t padding = GENERATE(0UL, 32UL);
  Far far({}, padding);
  {
    auto stream = far.open();
    if (!stream) FAIL(stream.error().text());
    CHECK((*stream)->stride() == 320 + padding);
    Timestamp last{0};
    for (int i = 0; i < 5; ++i) {
      const auto picture = (*stream)->next(100ms);
      REQUIRE(picture);
      REQUIRE(picture->stamp);
      CHECK(*picture->stamp > last);
      CHECK(*picture->stamp <= far.clock.now());
      CHECK(far.clock.now() - *picture->stamp < 5ms);
      last = *picture->stamp;
      const auto depth = depth_of({picture->bytes, (*stream)->stride()}, tests::video_model(), {});
      REQUIRE(depth);
      CHECK((*depth)[60 * 160 + 80] == Approx(1.33f).margin(0.2f));
    }
  }
  far.check_left_clean();
}

TEST_CASE("a device that is not there, or is none, is said in one sentence", "[v4l2]") {
  for (const auto& [error_number, code, expected] :
       {std::tuple{ENOENT, ErrorCode::LinkLost, "there is no /dev/video0"},
        std::tuple{ENODEV, ErrorCode::LinkLost, "there is no /dev/video0"},
        std::tuple{EACCES, ErrorCode::DeviceFault, "usermod -aG video"},
        std::tuple{EBUSY, ErrorCode::DeviceFault, "fuser -v /dev/video0"},
        std::tuple{EISDIR, ErrorCode::BadConfig, "is no device"},
        std::tuple{EMFILE, ErrorCode::DeviceFault, "Too many open files"}}) {
    const Error error = open_error("/dev/video0", error_number);
    INFO(error.text());
    CHECK(error.code == code);
    CHECK_THAT(error.detail, Catch::Contains(expected));
  }
  Far far;
  far.config.device = "/dev/video9";
  const auto stream = far.open();
  REQUIRE_FALSE(stream);
  CHECK(stream.error().code == ErrorCode::LinkLost);
  far.check_left_clean();
}

TEST_CASE("a device that cannot do it, or contradicts itself, is refused with the figure", "[v4l2]") {
  const Case cases[] = {
      {"metadata",
       of<v4l2_capability>(VIDIOC_QUERYCAP, [](auto& c) { c.device_caps = V4L2_CAP_META_CAPTURE; }),
       ErrorCode::BadConfig, "metadata"},
      {"output", of<v4l2_capability>(VIDIOC_QUERYCAP, [](auto& c) { c.device_caps = V4L2_CAP_VIDEO_OUTPUT; }),
       ErrorCode::BadConfig, "captures no video"},
      {"no streaming",
       of<v4l2_capability>(VIDIOC_QUERYCAP, [](auto& c) { c.device_caps = V4L2_CAP_VIDEO_CAPTURE; }),
       ErrorCode::BadConfig, "cannot stream"},
      {"no Z16", of<v4l2_fmtdesc>(VIDIOC_ENUM_FMT, [](auto& f) { f.pixelformat = V4L2_PIX_FMT_YUYV; }),
       ErrorCode::BadConfig, "no format Z16, only YUYV, YUYV"},
      {"formats without end",
       [](unsigned long request, void* argument) -> std::optional<int> {
         if (request != VIDIOC_ENUM_FMT) return std::nullopt;
         as<v4l2_fmtdesc>(argument).pixelformat = V4L2_PIX_FMT_YUYV;
         return 0;
       },
       ErrorCode::BadConfig, "no format Z16"},
      {"another format", of<v4l2_format>(VIDIOC_S_FMT, [](auto& f) { f.fmt.pix.pixelformat = 0x01020304; }),
       ErrorCode::DeviceFault, "gives ???? where it was asked for Z16"},
      {"another size", of<v4l2_format>(VIDIOC_S_FMT, [](auto& f) { f.fmt.pix.width = 640; }),
       ErrorCode::BadConfig, "gives 640 x 120 pixels, the intrinsics are for 160 x 120"},
      {"interlaced", of<v4l2_format>(VIDIOC_S_FMT, [](auto& f) { f.fmt.pix.field = V4L2_FIELD_INTERLACED; }),
       ErrorCode::DeviceFault, "interlaced"},
      {"short rows", of<v4l2_format>(VIDIOC_S_FMT, [](auto& f) { f.fmt.pix.bytesperline = 319; }),
       ErrorCode::DeviceFault, "rows of 319 bytes; 160 pixels of Z16 have 320"},
      {"no rows", of<v4l2_format>(VIDIOC_S_FMT, [](auto& f) { f.fmt.pix.bytesperline = 0; }),
       ErrorCode::DeviceFault, "rows of 0 bytes"},
      {"absurd rows", of<v4l2_format>(VIDIOC_S_FMT, [](auto& f) { f.fmt.pix.bytesperline = 0xffffffffU; }),
       ErrorCode::DeviceFault, "rows of 4294967295 bytes"},
      {"small image", of<v4l2_format>(VIDIOC_S_FMT, [](auto& f) { f.fmt.pix.sizeimage = 38399; }),
       ErrorCode::DeviceFault, "images of 38399 bytes"},
      {"absurd image", of<v4l2_format>(VIDIOC_S_FMT, [](auto& f) { f.fmt.pix.sizeimage = 0xffffffffU; }),
       ErrorCode::DeviceFault, "images of 4294967295 bytes"},
      {"another rate",
       of<v4l2_streamparm>(VIDIOC_S_PARM,
                           [](auto& p) {
                             p.parm.capture.timeperframe = {1, 6};
                           }),
       ErrorCode::BadConfig, "gives 6 images a second, asked for 30"},
      {"one buffer", of<v4l2_requestbuffers>(VIDIOC_REQBUFS, [](auto& r) { r.count = 1; }),
       ErrorCode::DeviceFault, "has 1 buffers"},
      {"absurd buffers", of<v4l2_requestbuffers>(VIDIOC_REQBUFS, [](auto& r) { r.count = 0xffffffffU; }),
       ErrorCode::DeviceFault, "has 4294967295 buffers"},
      {"small buffer", of<v4l2_buffer>(VIDIOC_QUERYBUF, [](auto& b) { b.length = 100; }),
       ErrorCode::DeviceFault, "buffer 0 of /dev/video0 has 100 bytes"},
      {"absurd buffer", of<v4l2_buffer>(VIDIOC_QUERYBUF, [](auto& b) { b.length = 0xffffffffU; }),
       ErrorCode::DeviceFault, "has 4294967295 bytes"},
      {"another buffer", of<v4l2_buffer>(VIDIOC_QUERYBUF, [](auto& b) { b.index = 7; }),
       ErrorCode::DeviceFault, "buffer 0"},
  };
  for (const Case& c : cases) {
    INFO(c.name);
    Far far;
    far.device.lie(c.lie);
    const auto stream = far.open();
    REQUIRE_FALSE(stream);
    INFO(stream.error().text());
    CHECK(stream.error().code == c.code);
    CHECK_THAT(stream.error().detail, Catch::Contains(c.expected));
    far.check_left_clean();
  }
}

TEST_CASE("each call that fails says which, and what to do", "[v4l2]") {
  const struct {
    unsigned long request;
    int error_number;
    ErrorCode code;
    const char* expected;
  } cases[] = {
      {VIDIOC_QUERYCAP, ENOTTY, ErrorCode::BadConfig, "is no video device"},
      {VIDIOC_QUERYCAP, ENODEV, ErrorCode::LinkLost, "is gone"},
      {VIDIOC_ENUM_FMT, EIO, ErrorCode::DeviceFault, "does not answer VIDIOC_ENUM_FMT"},
      {VIDIOC_S_FMT, EBUSY, ErrorCode::DeviceFault, "another program streams"},
      {VIDIOC_S_FMT, EINVAL, ErrorCode::DeviceFault, "refuses VIDIOC_S_FMT"},
      {VIDIOC_S_PARM, EPIPE, ErrorCode::DeviceFault, "does not answer VIDIOC_S_PARM"},
      {VIDIOC_REQBUFS, ENOMEM, ErrorCode::DeviceFault, "no memory for the buffers"},
      {VIDIOC_QUERYBUF, EINVAL, ErrorCode::DeviceFault, "refuses VIDIOC_QUERYBUF"},
      {VIDIOC_QBUF, EIO, ErrorCode::DeviceFault, "does not answer VIDIOC_QBUF"},
      {VIDIOC_STREAMON, ENOSPC, ErrorCode::DeviceFault, "no bandwidth left"},
      {VIDIOC_STREAMON, ETIMEDOUT, ErrorCode::DeviceFault, "does not answer VIDIOC_STREAMON"},
      {VIDIOC_STREAMON, EINTR, ErrorCode::DeviceFault, "refuses VIDIOC_STREAMON"},
  };
  for (const auto& c : cases) {
    INFO(c.expected);
    Far far;
    far.device.lie(fails(c.request, c.error_number));
    const auto stream = far.open();
    REQUIRE_FALSE(stream);
    CHECK(stream.error().code == c.code);
    CHECK_THAT(stream.error().detail, Catch::Contains(c.expected));
    far.check_left_clean();
  }
}

TEST_CASE("a device with one rate, or one that does not say its rate, is used as it is", "[v4l2]") {
  Far one, mute;
  one.device.lie(fails(VIDIOC_S_PARM, ENOTTY));
  CHECK(one.open());
  mute.device.lie(of<v4l2_streamparm>(VIDIOC_S_PARM, [](auto& p) { p.parm.capture.timeperframe = {0, 0}; }));
  CHECK(mute.open());
}

TEST_CASE("a call that a signal interrupts is made again", "[v4l2]") {
  Far far;
  int interrupted = 0;
  far.device.lie([&](unsigned long request, void*) -> std::optional<int> {
    if (request != VIDIOC_S_FMT || interrupted++ >= 3) return std::nullopt;
    return -EINTR;
  });
  CHECK(far.open());
  CHECK(interrupted == 4);
}

TEST_CASE("a damaged or short image is dropped with its reason, and images go on", "[v4l2]") {
  for (const auto& [fault, expected] :
       {std::pair{"0:damaged:0.3", "marked an image"}, std::pair{"0:short=50:0.3", "an image of 19200 bytes"},
        std::pair{"0:short=0:0.3", "an image of 0 bytes"}}) {
    INFO(fault);
    Far far({fault});
    auto stream = far.open();
    REQUIRE(stream);
    int dropped = 0;
    for (;;) {
      const auto picture = (*stream)->next(100ms);
      if (picture) break;
      REQUIRE(picture.error().code == ErrorCode::BadReply);
      CHECK_THAT(picture.error().detail, Catch::Contains(expected));
      REQUIRE(++dropped < 20);
    }
    CHECK(dropped >= 8);
    CHECK(far.clock.now() < 400ms);
    CHECK(far.device.report().not_taken == 0);  // each buffer was given back
  }
}

TEST_CASE("lies about a filled buffer end the stream, or drop the image", "[v4l2]") {
  const struct {
    const char* name;
    Lie lie;
    ErrorCode code;
    const char* expected;
  } cases[] = {
      {"index", of<v4l2_buffer>(VIDIOC_DQBUF, [](auto& b) { b.index = 4; }), ErrorCode::DeviceFault,
       "filled buffer 4 of 4"},
      {"length", of<v4l2_buffer>(VIDIOC_DQBUF, [](auto& b) { b.bytesused = 0xffffffffU; }),
       ErrorCode::BadReply, "an image of 4294967295 bytes"},
      {"lost", fails(VIDIOC_DQBUF, EIO), ErrorCode::BadReply, "EIO"},
      {"over", fails(VIDIOC_DQBUF, EINVAL), ErrorCode::DeviceFault, "streams no more"},
      {"gone", fails(VIDIOC_DQBUF, ENODEV), ErrorCode::LinkLost, "is gone"},
      {"spurious", fails(VIDIOC_DQBUF, EAGAIN), ErrorCode::Timeout, "no image"},
  };
  for (const auto& c : cases) {
    INFO(c.name);
    Far far;
    auto stream = far.open();
    REQUIRE(stream);
    far.device.lie(c.lie);
    const auto picture = (*stream)->next(100ms);
    REQUIRE_FALSE(picture);
    CHECK(picture.error().code == c.code);
    CHECK_THAT(picture.error().detail, Catch::Contains(c.expected));
  }
}

TEST_CASE("stamps of another clock, or that are no time, are no stamps", "[v4l2]") {
  const Lie lies[] = {
      of<v4l2_buffer>(VIDIOC_DQBUF, [](auto& b) { b.flags = 0; }),
      of<v4l2_buffer>(VIDIOC_DQBUF, [](auto& b) { b.flags = V4L2_BUF_FLAG_TIMESTAMP_COPY; }),
      of<v4l2_buffer>(VIDIOC_DQBUF, [](auto& b) { b.timestamp.tv_usec = 4'000'000; }),
      of<v4l2_buffer>(VIDIOC_DQBUF, [](auto& b) { b.timestamp.tv_sec = -1; }),
      of<v4l2_buffer>(VIDIOC_DQBUF, [](auto& b) { b.timestamp.tv_sec = std::numeric_limits<long>::max(); }),
  };
  for (const Lie& lie : lies) {
    Far far;
    auto stream = far.open();
    REQUIRE(stream);
    far.device.lie(lie);
    const auto picture = (*stream)->next(100ms);
    REQUIRE(picture);
    CHECK_FALSE(picture->stamp);
  }
}

TEST_CASE("a silent device is a timeout each time, in the time that was asked for", "[v4l2]") {
  Far far({"0:silent:100"});
  auto stream = far.open();
  REQUIRE(stream);
  const Timestamp before = far.clock.now();
  const auto picture = (*stream)->next(250ms);
  REQUIRE_FALSE(picture);
  CHECK(picture.error().code == ErrorCode::Timeout);
  CHECK(far.clock.now() - before == 250ms);
}

TEST_CASE("an unplugged device is gone at once, leaves nothing open, and can be opened again", "[v4l2]") {
  Far far({"0.5:unplug:1"});
  {
    auto stream = far.open();
    REQUIRE(stream);
    hal::Result<VideoPicture> picture = VideoPicture{};
    while (picture) picture = (*stream)->next(100ms);
    CHECK(picture.error().code == ErrorCode::LinkLost);
    CHECK_THAT(picture.error().detail, Catch::Contains("is gone"));
    CHECK(far.clock.now() >= 500ms);
    CHECK(far.clock.now() < 510ms);
    const auto again = (*stream)->next(100ms);
    CHECK_FALSE(again);
  }
  far.check_left_clean();
  CHECK_FALSE(far.open());
  far.clock.advance(1s);
  auto stream = far.open();
  REQUIRE(stream);
  CHECK((*stream)->next(100ms));
}

TEST_CASE("a client that is slow gets the images that had a buffer, and loses the rest", "[v4l2]") {
  Far far;
  auto stream = far.open();
  REQUIRE(stream);
  REQUIRE((*stream)->next(100ms));
  far.clock.advance(2s);
  int at_once = 0;
  const Timestamp before = far.clock.now();
  while (far.clock.now() == before && (*stream)->next(100ms)) ++at_once;
  CHECK(at_once >= 1);
  CHECK(at_once <= 5);
}

TEST_CASE("of several images that wait the newest is taken, and what is wrong among them is told", "[v4l2]") {
  Far far;
  auto stream = far.open();
  REQUIRE(stream);
  std::vector<std::string> dropped;
  far.clock.advance(120ms);
  const auto newest = (*stream)->newest(100ms, dropped);
  REQUIRE(newest);
  CHECK(far.clock.now() - *newest->stamp < 34ms);
  CHECK(far.device.report().handed_over == 3);
  CHECK(dropped.empty());

  // a damaged one behind a good one: the good one counts
  far.clock.advance(40ms);
  const Timestamp good_by = far.clock.now();
  int answered = 0;
  far.device.lie([&](unsigned long request, void* argument) -> std::optional<int> {
    if (request == VIDIOC_DQBUF && ++answered == 2) as<v4l2_buffer>(argument).flags |= V4L2_BUF_FLAG_ERROR;
    return std::nullopt;
  });
  far.clock.advance(30ms);
  const auto kept = (*stream)->newest(100ms, dropped);
  REQUIRE(kept);
  CHECK(*kept->stamp <= good_by);
  REQUIRE(dropped.size() == 1);
  CHECK_THAT(dropped.front(), Catch::Contains("damaged"));
}

}  // namespace colift::hal::v4l2
