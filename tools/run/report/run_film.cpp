#include "tools/run/report/run_film.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tools/run/report/run_pictures.hpp"
#include "tools/visualization/animated_png.hpp"
#include "tools/visualization/palette.hpp"

namespace colift::tools {
namespace {

constexpr int kWidth = 480, kHeight = 300;
constexpr std::size_t kPictures = 40;
constexpr double kPicture_s = 0.15, kLast_s = 2.0;

}  // namespace

std::optional<RunFilm> run_film(const RunView& view) {
  if (!view.scenes || view.scenes->film.size() < 2) return std::nullopt;
  const std::vector<FilmScene>& all = view.scenes->film;
  std::vector<picture::SolidScene> scenes;
  std::vector<const FilmScene*> shown;
  const std::size_t count = std::min(kPictures, all.size());
  picture::SolidScene everything;  // whatever moves stays in view
  for (std::size_t k = 0; k < count; ++k) {
    const FilmScene& scene = all[k * (all.size() - 1) / (count - 1)];
    shown.push_back(&scene);
    scenes.push_back(scene.scene);
    // a wall between the eye and the scene hides all of it
    std::erase_if(scenes.back().solids,
                  [](const picture::Solid& s) { return s.role == picture::SolidRole::Wall; });
    everything.solids.insert(everything.solids.end(), scenes.back().solids.begin(),
                             scenes.back().solids.end());
  }
  picture::SolidView eye = picture::view_of(everything, space_direction(view), kWidth, kHeight);
  eye.film = true;

  RunFilm film;
  film.from_s = shown.front()->t_s;
  film.to_s = shown.back()->t_s;
  picture::TextStyle words;
  words.size = 15.0;
  words.bold = true;
  std::vector<std::vector<std::uint8_t>> pictures;
  for (std::size_t k = 0; k < count; ++k) {
    picture::Canvas canvas = picture::draw_solids(scenes[k], eye);
    canvas.text({10.0, kHeight - 12.0},
                fmt::format("{}  {:.1f} s", control::word(shown[k]->state), shown[k]->t_s), words);
    if (k + 1 == count) film.still = canvas.png();
    pictures.push_back(canvas.rgb_bytes());
  }
  film.film = picture::animated_png(kWidth, kHeight, pictures, kPicture_s, kLast_s);
  return film;
}

}  // namespace colift::tools
