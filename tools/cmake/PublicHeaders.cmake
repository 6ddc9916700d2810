# What a program that uses the installed package may include. Everything else is CoLift's own and may change
# from one day to the next. A listed header includes listed headers only; tests/package/headers.cmake checks it.
set(COLIFT_PUBLIC_HEADERS
  # hal: devices, their guards, drivers, the robot's model
  hal/arm.hpp
  hal/config/config_file.hpp
  hal/depth_camera.hpp
  hal/device.hpp
  hal/drivers/barrett_can/make_barrett_hand.hpp
  hal/drivers/kinect/guarded_kinect.hpp
  hal/drivers/kuka_fri/make_kuka_arm.hpp
  hal/drivers/recorded/frame_file.hpp
  hal/drivers/recorded/recorded_camera.hpp
  hal/guards/guarded_arm.hpp
  hal/guards/guarded_camera.hpp
  hal/guards/guarded_hand.hpp
  hal/guards/t1_profile.hpp
  hal/hand.hpp
  hal/infrared_camera.hpp
  hal/os/make_can_bus.hpp
  hal/robot.hpp
  hal/robot_model/dynamics.hpp
  hal/robot_model/robot_model.hpp
  hal/types/geometry.hpp
  hal/types/joints.hpp
  hal/types/result.hpp
  hal/types/short_text.hpp
  hal/types/time.hpp
  hal/types/units.hpp
  # ... and what these include
  hal/can_bus.hpp
  hal/config/effective_yaml.hpp
  hal/config/field_table.hpp
  hal/config/range.hpp
  hal/config/yaml_tree.hpp
  hal/drivers/barrett_can/hand_config.hpp
  hal/drivers/kinect/kinect_config.hpp
  hal/drivers/kuka_fri/fri_config.hpp
  hal/drivers/recorded/cloud_files/point_file.hpp
  # perception: from a frame to a scene, a partner, a motion
  perception/calibration/calibration_file.hpp
  perception/map/world_map.hpp
  perception/bodies/body_finder.hpp
  perception/bodies/body_tracker.hpp
  perception/motion/object_motion.hpp
  perception/organised_cloud.hpp
  perception/partner/partner_grasp.hpp
  perception/partner/partner_tracker.hpp
  perception/scene.hpp
  perception/self_filter.hpp
  perception/shape/shape_completion.hpp
  perception/surfaces/find_surfaces.hpp
  # ... and what these include
  perception/calibration/calibrate.hpp
  perception/calibration/emitter_model.hpp
  perception/calibration/next_pose.hpp
  perception/calibration/pose_check.hpp
  perception/calibration/spot_finder.hpp
  perception/footprint.hpp
  perception/ground_and_target/block_planes.hpp
  perception/ground_and_target/components.hpp
  perception/ground_and_target/enclosed_pixels.hpp
  perception/ground_and_target/fragments.hpp
  perception/ground_and_target/ground.hpp
  perception/ground_and_target/image_border.hpp
  perception/ground_and_target/plane_vote.hpp
  perception/ground_and_target/slivers.hpp
  perception/ground_and_target/target.hpp
  perception/ground_and_target/walls.hpp
  perception/motion/moved_object.hpp
  perception/motion/object_motion_samples.hpp
  perception/noise_model.hpp
  perception/change_limit.hpp
  perception/partner/change_image.hpp
  perception/partner/grasp_presence.hpp
  perception/partner/local_shape.hpp
  perception/object_grid.hpp
  perception/partner/partner_contact.hpp
  perception/partner/partner_leg.hpp
  perception/reference_image.hpp
  perception/surfaces/surface_config.hpp
  perception/thesis/thesis_config.hpp
  # planner: load sharing, grasps, motions
  planner/grasp/grasp_candidates.hpp
  planner/grasp/grasp_decision.hpp
  planner/grasp/grasp_stability.hpp
  planner/grasp/robust_choice.hpp
  planner/grasp/task_choice.hpp
  planner/grasp_candidate.hpp
  planner/hand/hand_model.hpp
  planner/load_sharing/load_limits.hpp
  planner/load_sharing/load_sharing.hpp
  planner/load_sharing/rank.hpp
  planner/load_sharing/several_agents.hpp
  planner/motion/motion_planner.hpp
  planner/motion/trajectory/trajectory.hpp
  # ... and what these include
  planner/grasp/grasp_lines.hpp
  planner/hand/completed_shape.hpp
  planner/hand/hand_collision.hpp
  planner/hand/hand_sweep.hpp
  planner/hand/leg_face.hpp
  planner/hand/obstacles.hpp
  planner/hand/seen_space.hpp
  planner/motion/collision/collision_scene.hpp
  planner/motion/collision/collision_spheres.hpp
  planner/motion/collision/distance_field.hpp
  planner/motion/collision/exact_checker.hpp
  planner/motion/collision/fast_checker.hpp
  planner/motion/collision/touch.hpp
  planner/motion/inverse_kinematics/arm_ik.hpp
  planner/motion/search_config.hpp
  # control: configuration; look, decide, run
  control/config/config.hpp
  control/config/load_config.hpp
  control/config/test_lift_config.hpp
  control/config/resolve_config.hpp
  control/session/decide.hpp
  control/session/library_layout.hpp
  control/session/scene_analysis.hpp
  control/session/suggest.hpp
  control/session/perception_session.hpp
  control/task/intent.hpp
  control/task/run_job.hpp
  control/task/run_record.hpp
  control/task/task_machine.hpp
  # ... and what these include
  control/arm/drive.hpp
  control/config/check_config.hpp
  control/config/method.hpp
  control/config/monitor_config.hpp
  control/config/setpoint_limits.hpp
  control/config/task_config.hpp
  control/config/recovery_config.hpp
  control/lift/load_estimator.hpp
  control/task/job_status.hpp
  control/test_lift/cog_belief.hpp
  control/test_lift/test_lift.hpp
  # sim_hal: mocks, synthetic frames, the simulated rig for own scenarios
  sim_hal/mock/mock_arm.hpp
  sim_hal/mock/mock_camera.hpp
  sim_hal/mock/mock_hand.hpp
  sim_hal/mujoco/devices/sim_devices.hpp
  sim_hal/mujoco/sim_world.hpp
  sim_hal/people/body_contact.hpp
  sim_hal/people/body_region.hpp
  sim_hal/scenario/random_scenario.hpp
  sim_hal/scenario/scenario.hpp
  sim_hal/synthetic/scenes.hpp
  # ... and what these include
  sim_hal/mock/fault_plan.hpp
  sim_hal/scenario/object_parts.hpp
  sim_hal/synthetic/hash_random.hpp
  sim_hal/synthetic/kinect/kinect_noise.hpp
  sim_hal/synthetic/ray_caster.hpp
  sim_hal/synthetic/ray_parts.hpp
  sim_hal/synthetic/shapes.hpp
  # tools: recordings are read, pictures drawn
  tools/telemetry/channels/recorded_frame.hpp
  tools/telemetry/mcap/mcap_reader.hpp
  tools/visualization/scene/scene_picture.hpp
  # ... and what these include
  tools/telemetry/mcap/byte_source.hpp
  tools/telemetry/mcap/mcap_records.hpp
  tools/visualization/canvas.hpp
)
# The suites that a back end of arm, hand or camera has to pass; they need Catch2 (target CoLift::contract).
set(COLIFT_CONTRACT_HEADERS arm_contract.hpp camera_contract.hpp catch.hpp hand_contract.hpp)
