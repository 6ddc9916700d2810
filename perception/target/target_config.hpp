#pragma once

#include "hal/config/range.hpp"
#include "perception/footprint.hpp"
#include "perception/ground/walls.hpp"
#include "perception/target/on_table.hpp"
#include "perception/target/outline.hpp"
#include "perception/target/person/limb_part.hpp"
#include "perception/target/person/limb_shape.hpp"
#include "perception/target/person/person_shape.hpp"
#include "perception/target/regions/enclosed_pixels.hpp"
#include "perception/target/regions/fragments.hpp"
#include "perception/target/second_look.hpp"
#include "perception/target/slivers.hpp"

namespace colift::perception {

/// What counts as an object to be carried.
struct TargetConfig {
  double clearance_m = 0.006;
  double clearance_sigma = 3.0;
  double max_range_m = 4.5;
  double max_height_m = 1.3;
  double min_thickness_m = 0.025;
  double min_area_m2 = 0.005;
  double max_cut = 0.5;
  double jump_base_m = 0.012;
  double jump_sigma = 3.0;
  double jump_steps = 1.5;
  int min_neighbours = 3;
  int min_pixels = 300;
  int min_unasked_pixels = 1000;
  double clearance_rms = 2.5;
  double max_floating_m = 0.5;
  double tall_width_ratio = 1.5;
  double max_span_m = 3.2;
  double max_massive_m3 = 0.5;
  double massive_height_m = 0.3;
  double min_massive_fill = 0.5;
  double min_massive_width_m = 0.7;
  double unseen_depth_m = 0.35;
  double max_attached = 0.5;
  double max_hidden = 0.2;
  double min_hidden_area_m2 = 0.04;
  double min_on_ground = 0.0;
  double min_confidence = 0.3;
  double max_person_span_m = 1.2;
  double max_limb_gap_m = 0.3;
  double max_limb_fraction = 0.4;
  double max_cut_out_limb_fraction = 1.0;
  double max_person_top_cut = 0.1;
  double max_person_side_cut = 0.15;
  double min_person_part_m = 0.5;
  double min_person_slenderness = 0.8;
  double top_cut_weight = 0.6;
  FragmentConfig fragments;
  WallConfig walls;
  EnclosedConfig enclosed;
  SliverConfig slivers;
  SecondLookConfig second_look;
  OutlineConfig outline;
  PersonShapeConfig person;
  LimbShapeConfig limb;
  LimbPartConfig limb_part;
  BoxTrim box;
  OnTableConfig on_table;

  template <class Visitor>
  void visit(Visitor& v) {
    v("clearance_m", clearance_m, hal::kNotNegative,
      "Max height of the ground's pixels, beside the noise (m).");
    v("clearance_sigma", clearance_sigma, hal::kNotNegative,
      "The same, in standard deviations of the depth noise.");
    v("max_range_m", max_range_m, hal::kPositive, "Max distance of a target from the camera (m).");
    v("max_height_m", max_height_m, hal::kPositive,
      "Max height of a target (m); taller things are persons or furniture that is not carried.");
    v("min_thickness_m", min_thickness_m, hal::kNotNegative,
      "Min height of a target over the ground (m); flatter things are unevenness of the ground.");
    v("min_area_m2", min_area_m2, hal::kPositive, "Min visible area of a target (m^2).");
    v("max_cut", max_cut, hal::kFraction,
      "Max fraction of a target's side that the left, right or bottom of the view cuts off.");
    v("jump_base_m", jump_base_m, hal::kNotNegative,
      "Max depth difference of neighbouring pixels on one surface, fixed part (m).");
    v("jump_sigma", jump_sigma, hal::kNotNegative, "The same, in standard deviations of the depth noise.");
    v("jump_steps", jump_steps, hal::kNotNegative, "The same, in quantisation steps.");
    v("min_neighbours", min_neighbours, hal::Range{0, 8},
      "Min number of neighbours at its own depth of a pixel that is kept; others are flying pixels.");
    v("min_pixels", min_pixels, hal::Range{1, 1e6}, "Min number of pixels of a target.");
    v("min_unasked_pixels", min_unasked_pixels, hal::Range{1, 1e6}, "The same, where nobody pointed at it.");
    v("clearance_rms", clearance_rms, hal::Range{0, 100},
      "Max height of the ground's pixels on an uneven floor, in root mean square residuals of the ground.");
    v("max_floating_m", max_floating_m, hal::kPositive,
      "Max height over the ground at which the lowest part that is seen of a target begins (m).");
    v("tall_width_ratio", tall_width_ratio, hal::kPositive,
      "What is taller than max_height_m is a desk with things on it, and no stairs or person, when its "
      "footprint reaches over at least this many times its height.");
    v("max_span_m", max_span_m, hal::kPositive, "Max diagonal of a target's footprint (m).");
    v("max_massive_m3", max_massive_m3, hal::kPositive,
      "Max volume of a target that is closed down to the ground (m^3): a sofa, a cupboard, stairs.");
    v("massive_height_m", massive_height_m, hal::kPositive,
      "Height over the ground up to which it is looked whether an object is closed (m).");
    v("min_massive_fill", min_massive_fill, hal::kFraction,
      "Min fraction of its width, up to that height, that an object fills when it counts as closed.");
    v("min_massive_width_m", min_massive_width_m, hal::kPositive,
      "Min width of an object that may be too massive to carry (m).");
    v("unseen_depth_m", unseen_depth_m, hal::kNotNegative,
      "Depth that a closed object has at least, also when only its front is seen (m).");
    v("max_attached", max_attached, hal::kFraction,
      "Max fraction of a target's outline along which something is at its own depth, in front of it, or the "
      "view ends.");
    v("max_hidden", max_hidden, hal::kFraction,
      "Max fraction of a target's outline that something in front of it hides, where little of it is seen "
      "...");
    v("min_hidden_area_m2", min_hidden_area_m2, hal::kNotNegative,
      "... namely less than this area (m^2): it may be anything.");
    v("min_confidence", min_confidence, hal::kFraction,
      "Min confidence with which an object is taken for the target; below it a person has to point at it.");
    v("min_on_ground", min_on_ground, hal::kFraction,
      "Min fraction of a target's outline along which the ground begins.");
    v("max_person_span_m", max_person_span_m, hal::kPositive,
      "Max diagonal of the footprint of what may be a person by its height alone (m).");
    v("max_limb_gap_m", max_limb_gap_m, hal::kNotNegative,
      "Max distance from a person of what may be the person's arm or leg (m).");
    v("max_limb_fraction", max_limb_fraction, hal::kFraction,
      "Max number of pixels of such an arm or leg, as a fraction of the person's.");
    v("max_cut_out_limb_fraction", max_cut_out_limb_fraction, hal::kNotNegative,
      "The same of what had to be cut out of what it hangs together with.");
    v("max_person_top_cut", max_person_top_cut, hal::kFraction,
      "A slender object, of whose upper side the view cuts off more than this fraction, may be a person.");
    v("max_person_side_cut", max_person_side_cut, hal::kFraction,
      "The same of a side: what is seen of it may be a part of one ...");
    v("min_person_part_m", min_person_part_m, hal::kNotNegative, "... if it is higher than this (m).");
    v("min_person_slenderness", min_person_slenderness, hal::kPositive,
      "Min ratio of height to footprint of such a slender object.");
    v("top_cut_weight", top_cut_weight, hal::kFraction,
      "Weight in max_cut of the fraction of the upper side that the view cuts off: it hides height, not "
      "footprint.");
    v("fragments", fragments, "How image regions are joined to objects.");
    v("walls", walls, "What counts as a wall.");
    v("enclosed", enclosed, "Pixels that the object surrounds in the image.");
    v("box", box, "Which stray points the object's box leaves out.");
    v("slivers", slivers, "Small regions that belong to the object without being a surface of it.");
    v("second_look", second_look, "How what hangs together with its background is cut apart.");
    v("outline", outline, "How the outline of an object is read.");
    v("person", person, "What a head on shoulders looks like.");
    v("limb", limb, "What is as round as a part of a person.");
    v("limb_part", limb_part, "What may be an arm or a leg that the view shows apart from its person.");
    v("on_table", on_table, "What counts as a target where the support is a table top.");
  }
};

}  // namespace colift::perception
