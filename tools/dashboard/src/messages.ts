// The shapes of CoLift's channels as the page uses them (tools/telemetry/channels/channels.cpp is their description).

export interface Xyz { x: number; y: number; z: number }
export interface Quaternion { x: number; y: number; z: number; w: number }
export interface Pose { position: Xyz; orientation: Quaternion }
export interface Colour { r: number; g: number; b: number; a: number }

export interface TaskStatus {
  t: number; state: string; in_state_s: number; because: string; waits_for: string; doing: string;
  done: number | null; partner: number[] | null; partner_note: string; separation: Separation; force: Force;
}
export interface Body { id: number; partner: boolean; distance_m: number | null }
export interface Separation {
  on: boolean; speed_scale: number; waits: boolean; because: string; distance_m: number | null;
  may_confirm?: boolean; // the arm stopped, and waits for an operator's confirmation
  hold_distance_m: number; slow_distance_m: number; bodies: Body[];
}
export interface Force {
  on: boolean; felt: number[]; sideways_limit_n: number | null; up_limit_n: number | null; down_limit_n: number | null;
  exceeded: boolean;
}
export interface Intent { t: number; motion: string | null; in_s: number; says: string }
export interface TaskChange { t: number; state: string; because: string }
export interface Candidate {
  id: number; kind: string; position: number[]; approach: number[]; closing: number[]; width: number | null;
  verdict: string; because: string; stability: number | null; share: number | null; cost: number | null;
}
export interface Decision {
  t: number; chosen: number | null; share: number | null; cost: number | null; because: string;
  share_text?: string;  // not in older recordings
  candidates: Candidate[];
}
export interface Plan { t: number; transit_s: number; approach_s: number; postures: number[][]; palm: number[][] }
export interface Device { name: string; state: string; accepted: number; rejected: number; last_error: string }
export interface CycleTiming {
  cycles: number; missed: number; period_ms_max: number | null; answer_us_mean: number | null;
  answer_us_max: number | null; lost_samples: number;
}
export interface Stages {
  look_ms: Record<string, number>; decision_ms: number; decision_compute_ms: number; plan_ms: number;
  grasp_to_decision_s: number | null;
}
export interface Load {
  load_n: number; share: number | null; share_predicted: number | null; height_m: number | null;
  tilt_deg: number | null; slip_m: number | null;
  leads?: string | null;  // "robot" or "partner"; not in older recordings
  energy_j?: number | null;  // that the arm may still put into object and people; neither
}
export interface Tactile {
  arrays: { name: string; force_n: number | null; cells: (number | null)[] }[];
  palm_touches: boolean;
}
export interface Calibration { width: number; height: number; K: number[] }
export interface RawImage { width: number; height: number; encoding: string; data: string }
export interface Log { timestamp: { sec: number; nsec: number }; level: number; message: string; name: string }
export interface Transform {
  parent_frame_id: string; child_frame_id: string; translation: Xyz; rotation: Quaternion;
}
export interface JointStates { joints: { name: string; position: number }[] }
export interface PointCloud {
  frame_id: string; pose: Pose; point_stride: number; fields: { name: string; offset: number; type: number }[];
  data: string;
}
export interface Solid { pose: Pose; size: Xyz; color: Colour; bottom_scale?: number; top_scale?: number }
export interface Arrow {
  pose: Pose; shaft_length: number; shaft_diameter: number; head_length: number; head_diameter: number; color: Colour;
}
export interface Line { type: number; pose: Pose; points: Xyz[]; color: Colour }
export interface Entity {
  id: string; metadata: { key: string; value: string }[];
  arrows: Arrow[]; cubes: Solid[]; spheres: Solid[]; cylinders: Solid[]; lines: Line[];
}
export interface SceneUpdate { deletions: { type: number; id: string }[]; entities: Entity[] }

export function bytesOf(base64: string): Uint8Array {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes;
}
