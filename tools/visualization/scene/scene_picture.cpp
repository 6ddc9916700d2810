#include "tools/visualization/scene/scene_picture.hpp"

#include <algorithm>
#include <cmath>

#include "tools/visualization/canvas.hpp"
#include "tools/visualization/file_output.hpp"
#include "tools/visualization/palette.hpp"
#include "tools/visualization/scene/camera_view.hpp"
#include "tools/visualization/scene/frame_raster.hpp"
#include "tools/visualization/scene/scene_marks.hpp"
#include "tools/visualization/scene/side_panel.hpp"
#include "tools/visualization/scene/top_view.hpp"

namespace colift::picture {
namespace {

constexpr double kPanelWidth = 460, kMargin = 24;
constexpr double kTopViewMin = 360, kTopViewHeading = 28;
constexpr int kImageWidth = 1280, kEmptyHeight = 520;

}  // namespace

Canvas draw_scene_picture(const ScenePicture& what) {
  const bool image = what.cloud && what.cloud->size() > 0;
  const int scale = image ? picture_scale(*what.cloud) : 1;
  const int image_width = image ? scale * what.cloud->width() : kImageWidth;
  const int image_height = image ? scale * what.cloud->height() : kEmptyHeight;

  // heights first, so that nothing is ever cut
  Canvas ruler(1, 1, kPaper);
  const Box panel{image_width + kMargin, kMargin, kPanelWidth - 2 * kMargin, 0};
  const Box legend{kMargin, image_height + 14.0, image_width - 2 * kMargin, 0};
  const double legend_end = draw_legend(ruler, legend, what, false);
  const double panel_end = draw_panel(ruler, panel, what, false);
  const bool top_view = has_top_view(what);
  const double panel_need = panel_end + (top_view ? kTopViewHeading + kTopViewMin + kMargin : kMargin);
  const int height = static_cast<int>(std::ceil(std::max(legend_end + 16, panel_need)));

  Canvas canvas(image_width + static_cast<int>(kPanelWidth), height, kPaper);
  canvas.fill(Box{static_cast<double>(image_width), 0, kPanelWidth, static_cast<double>(height)}, kPanel);
  if (image) {
    canvas.image(0, 0, image_width, image_height, frame_raster(what, scale));
    draw_marks(canvas, CameraView(*what.cloud, scale), what);
  } else {
    const Box empty{0, 0, static_cast<double>(image_width), static_cast<double>(image_height)};
    canvas.fill(empty, kMissing);
    canvas.text(empty.center(), "no depth image", {.size = 22, .colour = kRule, .align = Align::Middle});
  }
  draw_legend(canvas, legend, what, true);
  double y = draw_panel(canvas, panel, what, true);
  if (top_view) {
    canvas.text({panel.x, y + 16}, "FROM ABOVE", {.size = 15, .colour = rgb(0x5A6573), .bold = true});
    y += kTopViewHeading;
    const Box area{panel.x, y, panel.width, std::min(height - y - kMargin, 1.45 * panel.width)};
    draw_top_view(canvas, area, what);
    canvas.outline(area, {.colour = kRule, .width = 1.2}, 6);
  }
  return canvas;
}

int picture_scale(const perception::OrganisedCloud& cloud) {
  return std::clamp(
      static_cast<int>(std::lround(static_cast<double>(kImageWidth) / std::max(1, cloud.width()))), 1, 16);
}

std::vector<std::uint8_t> scene_picture_png(const ScenePicture& what) {
  return draw_scene_picture(what).png();
}

hal::Result<> write_scene_picture(const std::filesystem::path& png, const ScenePicture& what) {
  return write_file(png, scene_picture_png(what));
}

}  // namespace colift::picture
