#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/types/result.hpp"
#include "perception/noise_model.hpp"
#include "perception/object_grid.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/partner/change_image.hpp"
#include "perception/partner/hidden_edge.hpp"
#include "perception/partner/partner_contact.hpp"
#include "perception/partner/partner_leg.hpp"
#include "perception/reference_image.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// What counts as a hand on the object.
struct PartnerConfig {
  ChangeConfig change;
  double reach_m = 0.50;       ///< Changes farther from the object's box than this are not looked at.
  double min_body_m2 = 0.003;  ///< A hand covers more than this, even half hidden.
  double min_part_m2 =
      0.0006;  ///< Smallest connected part of it that is looked at: two fingers over an edge.
  double min_known_part_m2 = 0.0003;  ///< The same where a hand was seen in the frames before.
  int known_frames = 8;  ///< So many frames after a hand was last seen, where it was is not known any more.
  double touch_m =
      0.030;  ///< Skin this near to the object, plus noise, touches it: the back of a holding hand.
  double hand_thickness_m = 0.045;  ///< The visible side of a touching hand may be this far from the object.
  double clear_m = 0.10;            ///< A body that keeps this distance passes by.
  double min_touch_m2 = 0.0004;  ///< Area of skin within hand_thickness_m that a holding hand shows at least.
  double along_sigma_m =
      0.005;  ///< Error of a contact along the object's edge, measured on synthetic frames ...
  double cross_sigma_m = 0.005;  ///< ... and across it.
  double cell_m = 0.015;         ///< Size of the patches into which the object's surface is divided.
  double max_uncovered_fraction = 0.25;
  /// Placed between the flicker of edges in synthetic frames (0.35 %) and a real camera that moved (0.85 %).
  double max_receded_fraction = 0.007;
  double receded_m = 0.02;
  int max_hands = 4;
  int max_hand_points = 400;
  double fingertip_m2 = 0.0001;  ///< Area that has to be as near: single pixels say nothing.
  double hand_cell_m = 0.04;
  double outline_step_m = 0.04;
  int body_gap_px = 8;
  double min_hidden_edge = 0.08;
  ReferenceConfig reference;
  LegConfig legs;
  ContactConfig contact;

  template <class Visitor>
  void visit(Visitor& v) {
    v("change", change, "Which pixels count as changed.");
    v("reach_m", reach_m, hal::Range{0.1, 5.0},
      "Distance around the object within which a partner is searched (m).");
    v("min_body_m2", min_body_m2, hal::Range{0.0, 1.0},
      "Min visible area of a partner's hand and forearm (m^2).");
    v.renamed("smallest_body_m2", "min_body_m2");
    v("min_part_m2", min_part_m2, hal::Range{0.0, 1.0},
      "Min visible area of a connected part of a partner's body (m^2).");
    v.renamed("smallest_part_m2", "min_part_m2");
    v("min_known_part_m2", min_known_part_m2, hal::Range{0.0, 1.0},
      "The same where a hand touched the object in the frames before: one that shows little is not lost and "
      "found from frame to frame (m^2).");
    v("known_frames", known_frames, hal::Range{0, 1000},
      "Number of frames for which it is known where a hand was seen.");
    v("touch_m", touch_m, hal::Range{0.0, 0.1}, "Max gap between skin and object that is a touch (m).");
    v("hand_thickness_m", hand_thickness_m, hal::Range{0.0, 0.2},
      "Max thickness of a hand on the object (m).");
    v("clear_m", clear_m, hal::Range{0.0, 0.5}, "Min distance of a passer-by from the object (m).");
    v("min_touch_m2", min_touch_m2, hal::Range{0.0, 0.1}, "Min visible area of a touching hand (m^2).");
    v.renamed("smallest_touch_m2", "min_touch_m2");
    v("along_sigma_m", along_sigma_m, hal::Range{0.001, 0.1},
      "Standard deviation of a contact along the object's edge (m).");
    v("cross_sigma_m", cross_sigma_m, hal::Range{0.001, 0.1},
      "Standard deviation of a contact across the object's edge (m).");
    v("cell_m", cell_m, hal::Range{0.003, 0.1},
      "Size of the patches into which the object's surface is divided (m).");
    v("max_uncovered_fraction", max_uncovered_fraction, hal::kFraction,
      "Max fraction of the object's pixels that show what was behind it; beyond, the object was moved.");
    v("max_receded_fraction", max_receded_fraction, hal::kFraction,
      "Max fraction of the view that lies farther than in the reference; beyond, camera or scene moved.");
    v("receded_m", receded_m, hal::Range{0.0, 1.0},
      "Min distance, beyond the noise, by which a pixel lies farther than in the reference (m).");
    v("max_hands", max_hands, hal::Range{1, 16},
      "Max number of hands on the object; the largest ones count.");
    v("max_hand_points", max_hand_points, hal::Range{20, 100000},
      "Number of a hand's points above which only every n-th one is used.");
    v("fingertip_m2", fingertip_m2, hal::Range{0.0, 0.01},
      "Min area of skin that defines a distance or a touch: a fingertip (m^2).");
    v("hand_cell_m", hand_cell_m, hal::Range{0.005, 0.5},
      "Max gap in the skin of one hand on the object's surface, about (m).");
    v("outline_step_m", outline_step_m, hal::Range{0.0, 1.0},
      "Min depth step to what is behind the object at its outline (m).");
    v("body_gap_px", body_gap_px, hal::Range{0, 200},
      "Max gap in the image between a body and a small part of it, such as fingers beyond an edge (px).");
    v("min_hidden_edge", min_hidden_edge, hal::kFraction,
      "Fraction of the object's edge that a body hides at least where his hand may be behind it.");
    v("reference", reference, "When the reference image shows a scene at rest.");
    v("legs", legs, "How legs that touch the object are told from hands.");
    v("contact", contact, "Where on the object a hand holds it.");
  }
};

/// What the frame shows of a partner.
enum class PartnerKind {
  None,         ///< Nothing of a hand's size changed near the object.
  PasserBy,     ///< Somebody is there, at clear_m or more from the object, however much of it he hides in the
                ///< image.
  Near,         ///< Nearer than that, but nothing touches, or only a leg or the trunk.
  Grasp,        ///< At least one hand touches the object.
  ObjectMoved,  ///< The object, the camera or the scene is no longer where the reference shows it; a new one
                ///< is needed.
};

/// One hand on the object.
struct PartnerContact {
  Vec3 position = Vec3::Zero();  ///< Middle of the contact, on the object.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::size_t points = 0;    ///< Changed points of the hand that the estimate rests on.
  Vec3 skin = Vec3::Zero();  ///< Middle of its visible skin on the object: steadier than the contact.
};

/// What one frame shows of the partner.
struct PartnerObservation {
  PartnerKind kind = PartnerKind::None;
  /// Set with kind Grasp. With two hands the position is the middle between the contacts: two hands that
  /// share their load equally act like one there, which is what the load-sharing decision asks for.
  std::optional<PartnerGrasp> grasp;
  std::vector<PartnerContact> contacts;  ///< One for each hand, largest first.
  std::vector<Vec3> legs;  ///< Where something touches the object that looks like a leg or a trunk.
  std::optional<double>
      nearest_m;  ///< Smallest distance of a changed body from the object, when within reach.
  std::vector<std::uint32_t> pixels;  ///< Changed pixels of the bodies near the object, ascending.
  /// Where nothing touches but a body stands before the object: the edge that it hides.
  std::optional<HiddenEdge> hidden_edge;
  std::string reason;  ///< What was seen, in a person's words, with numbers.
};

/// Finds the partner's hands on one object. The reference image and the object are digested once (a few
/// ms); find() then costs some tenths of a millisecond. Keeps its buffers from frame to frame: one finder,
/// one thread. Source of the task: thesis 5.3.3; the method is CoLift's own (docs/decisions/0003).
class PartnerFinder {
 public:
  /// `target` holds pixels of the reference image. Points are taken from the reference at these pixels, or
  /// from target.points when it has no pixels. The ground tells legs from hands. Errors: BadInput (pixel
  /// outside of the image, object without points).
  [[nodiscard]] static hal::Result<PartnerFinder> make(const ReferenceImage& reference, const Target& target,
                                                       const Ground& ground, const NoiseModel& noise,
                                                       const PartnerConfig& config);

  /// Errors: BadInput when the frame's size or camera pose is not the reference's.
  [[nodiscard]] hal::Result<PartnerObservation> find(const OrganisedCloud& current);

  /// Outline of the object as the camera sees it (points in W): where a hand can reach around.
  [[nodiscard]] const std::vector<Eigen::Vector3f>& rim() const { return rim_; }

 private:
  /// A changed point near the object.
  struct Skin {
    Eigen::Vector3f point;
    float distance_m;  ///< To the patch.
    float area_m2;
    float depth_m;       ///< Along Cz.
    std::int32_t patch;  ///< Nearest patch of the object.
    std::int32_t hand;   ///< Which hand; none yet: -1.
  };

  PartnerFinder(const ReferenceImage& reference, const Ground& ground, const NoiseModel& noise,
                const PartnerConfig& config, std::vector<std::uint32_t> pixels,
                const std::vector<Eigen::Vector3f>& points, const PixelWindow& window);

  [[nodiscard]] bool same_camera(const OrganisedCloud& current) const;
  [[nodiscard]] double moved_part(const OrganisedCloud& current) const;
  [[nodiscard]] double receded_part(const OrganisedCloud& current) const;
  void choose_components();
  [[nodiscard]] double min_part_m2(const PixelWindow& box) const;
  void note_hands(const OrganisedCloud& current, const PartnerObservation& observation);
  void collect_skin(const OrganisedCloud& current, PartnerObservation& observation);
  void separate_hands();
  [[nodiscard]] float touch_gap(float depth_m) const;
  [[nodiscard]] float hand_gap(float depth_m) const;
  [[nodiscard]] std::optional<PartnerContact> contact(int hand);
  void note_hidden_edge(const OrganisedCloud& current, PartnerObservation& observation) const;
  void drop_legs(const OrganisedCloud& current, PartnerObservation& observation);
  void number_patch_cells();
  void find_rim(const ReferenceImage& reference);

  PartnerConfig config_;
  NoiseModel noise_;
  Ground ground_;
  hal::CameraIntrinsics intrinsics_;
  hal::Pose X_WC_;
  std::vector<std::uint32_t> object_pixels_;
  std::vector<float>
      object_far_m_;  ///< Depth beyond which an object's pixel shows what is behind the object.
  std::vector<std::uint32_t> samples_;  ///< Pixels all over the window ...
  std::vector<float> sample_far_m_;     ///< ... and the depths beyond which they show what nobody uncovered.
  std::vector<Eigen::Vector3f> rim_;
  ObjectGrid grid_;
  ChangeImage change_;

  // buffers of find(), kept between frames
  std::vector<Skin> skin_;
  std::vector<HandPoint> hand_;
  std::vector<std::uint8_t> chosen_;         ///< By component: 1 when it is part of a body.
  std::vector<std::int32_t> cell_of_patch_;  ///< Coarse cell in which a patch lies.
  std::array<int, 3> cells_{};               ///< Coarse cells along x, y, z.
  std::vector<std::int32_t> hand_of_cell_;   ///< -1 where no hand is.
  std::vector<std::int32_t> touched_cells_;
  int hands_ = 0;
  std::vector<OrganisedCloud::Projection> known_hands_;  ///< Where hands were seen last.
  int unseen_frames_ = 0;                                ///< Since then.
  double body_m2_ = 0.0;                                 ///< Changed area of all bodies in the window.
};

}  // namespace colift::perception
