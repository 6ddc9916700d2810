// Figures as people read them: no "-0.0", no share of a load that is not there.

import type { Force, Load, Separation } from "./messages";

/** A figure with so many digits; never "-0.0". */
export function figure(value: number, digits = 0): string {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? (0).toFixed(digits) : text;
}

export function percent(value: number | null): string {
  return value === null ? "" : `${figure(100 * value)} %`;
}

export function seconds(s: number): string {
  return s < 0.05 ? "" : `${s.toFixed(1)} s`;
}

export function escaped(text: string): string {
  return text.replace(/[&<>"']/g, (c) => `&#${c.charCodeAt(0)};`);
}

/** Less is what the load estimate says of an empty hand (N). */
const CARRIED_N = 2;

/** "5.0 cm up", "0.4 cm below the grasp"; empty where it is as it was. */
export function heightWords(height_m: number): string {
  const text = figure(100 * Math.abs(height_m), 1);
  if (Number(text) === 0) return "not raised";
  return `${text} cm ${height_m > 0 ? "up" : "below the grasp"}`;
}

/** Null: nothing is carried, and what was said before stays. */
export function loadWords(load: Load): string | null {
  if (load.share === null && load.height_m === null) return null;
  const rest = (load.tilt_deg === null ? "" : `, tilt ${figure(load.tilt_deg, 1)}°`) +
    (load.height_m === null ? "" : `, ${heightWords(load.height_m)}`) +
    (load.energy_j == null ? "" : `; the arm may still give ${figure(load.energy_j, 1)} J`);
  if (load.load_n < CARRIED_N || (load.share ?? 1) <= 0) return `The robot carries nothing${rest}`;
  // the share is known when the weight is
  return `The robot carries ${figure(load.load_n)} N` + (load.share === null ? "" : `, ${percent(load.share)} of the load`) +
    (load.share === null || load.share_predicted === null ? "" : ` (predicted ${percent(load.share_predicted)})`) + rest;
}

export function leaderWords(leads: string | null | undefined): string {
  return leads === "robot" ? "robot leads" : leads === "partner" ? "partner leads" : "";
}

export function separationWords(s: Separation): string {
  if (!s.on) return "nobody looks";
  const bodies = s.bodies.filter((b) => b.distance_m !== null).length;
  const near = s.distance_m === null ? "nobody near the arm"
    : `nearest ${figure(Math.max(0, s.distance_m), 2)} m${bodies > 1 ? ` of ${bodies} bodies` : ""}`;
  if (s.may_confirm) return `The arm waits for confirmation, press Continue: ${s.because}`;
  if (s.waits) return `The arm waits: ${s.because || near}`;
  if (s.speed_scale < 1) return `The arm moves at ${percent(s.speed_scale)} of its speed: ${s.because || near}`;
  return near;
}

export function forceWords(f: Force): string {
  const [x = 0, y = 0, z = 0] = f.felt;
  const of = (limit: number | null) => (limit === null ? "" : ` of ${limit.toFixed(0)}`);
  if (!f.on) return "force monitoring is off";
  if (f.sideways_limit_n === null) return "";
  return `Force on the hand: ${figure(Math.hypot(x, y))}${of(f.sideways_limit_n)} N sideways, ` +
    (z >= 0 ? `${figure(z)}${of(f.up_limit_n)} N up` : `${figure(-z)}${of(f.down_limit_n)} N down`);
}
