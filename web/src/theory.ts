/** The string's linear theory, as docs/theory.md has it: equilibria, and where rotation loses its stability. */

/** Parameters of string and bit, by their names in the interface table. */
export interface DrillString {
  G: number;
  J: number;
  I: number;
  L: number;
  I_B: number;
  c_a: number;
  c_b: number;
  R_b: number;
  mu_cb: number;
  mu_sb: number;
  gamma_b: number;
  v_f: number;
}

export const STRING_NAMES = [
  "G", "J", "I", "L", "I_B", "c_a", "c_b", "R_b", "mu_cb", "mu_sb", "gamma_b", "v_f",
] as const satisfies readonly (keyof DrillString)[];

/** [N m s/rad] */
export function impedance(p: DrillString): number {
  return Math.sqrt(p.I * p.G * p.J);
}

/** [s] */
export function travelTime(p: DrillString): number {
  return p.L * Math.sqrt(p.I / (p.G * p.J));
}

/** Torque on a bit that turns forward, eq. (3) [N m]. */
export function bitTorque(p: DrillString, weight: number, speed: number): number {
  const mu = p.mu_cb + (p.mu_sb - p.mu_cb) * Math.exp((-p.gamma_b * speed) / p.v_f);
  return p.c_b * speed + weight * p.R_b * mu;
}

/** Drive speed with which the bit turns evenly [rad/s]. */
export function driveSpeed(p: DrillString, weight: number, speed: number): number {
  return speed + bitTorque(p, weight, speed) / p.c_a;
}

/** Greatest speed with which the bit can turn evenly at a drive speed [rad/s], null if there is none. */
export function evenSpeed(p: DrillString, drive: number, weight: number): number | null {
  let above = drive;
  let below = drive;
  const pace = Math.max(drive, 1e-6) / 2048;
  while (driveSpeed(p, weight, below) > drive) {
    above = below;
    below -= pace;
    if (below <= 0) {
      return null;
    }
  }
  for (let round = 0; round < 60; ++round) {
    const middle = 0.5 * (above + below);
    if (driveSpeed(p, weight, middle) > drive) {
      above = middle;
    } else {
      below = middle;
    }
  }
  return below;
}

/** The string as the bit feels it at i nu, without the bit's own inertia: real and imaginary part [N m s/rad]. */
function felt(p: DrillString, nu: number): readonly [number, number] {
  const z = impedance(p);
  const reflection = (p.c_a - z) / (p.c_a + z);
  const phase = 2 * nu * travelTime(p);
  const [x, y] = [reflection * Math.cos(phase), -reflection * Math.sin(phase)];
  const size = (1 - x) ** 2 + y ** 2;
  return [(z * (1 - reflection ** 2)) / size, (2 * z * y) / size];
}

/** Slope of the torque on bit over its speed below which even rotation is unstable [N m s/rad]. */
export function criticalSlope(p: DrillString): number {
  const balance = (nu: number): number => p.I_B * nu + felt(p, nu)[1];
  const most = 12 * (Math.PI / travelTime(p));
  const pace = most / 6000;
  let least = p.c_a; // at nu = 0 the bit feels the drive alone
  for (let nu = pace; nu < most; nu += pace) {
    if (balance(nu) * balance(nu + pace) > 0) {
      continue;
    }
    let [low, high] = [nu, nu + pace];
    for (let round = 0; round < 60; ++round) {
      const middle = 0.5 * (low + high);
      if (balance(low) * balance(middle) > 0) {
        low = middle;
      } else {
        high = middle;
      }
    }
    least = Math.min(least, felt(p, low)[0]);
  }
  return -least;
}

/** Drive speed below which even rotation is unstable at a weight, given the critical slope [rad/s]; null if none is. */
export function threshold(p: DrillString, weight: number, slope: number): number | null {
  const rate = p.gamma_b / p.v_f;
  const steepest = weight * p.R_b * (p.mu_sb - p.mu_cb) * rate;
  const ratio = steepest / (p.c_b - slope);
  return ratio > 1 && rate > 0 ? driveSpeed(p, weight, Math.log(ratio) / rate) : null;
}
