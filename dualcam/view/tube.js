/** A tube with helical slots, as one mesh per surface: walls with true holes, flanks of the slots, rims. */
import { BufferGeometry, Float32BufferAttribute } from "three";

const COLUMNS = 160; // around the circumference
const END_COLUMNS = 9; // of the round end of a slot

/**
 * @typedef {object} Slot
 * @property {number[]} angle of the centre line, increasing [rad]
 * @property {number[]} z of the centre line
 */

/** Where a slot is cut at one angle: {low, high}, or null. Slots have round ends of the pin's radius. */
function cutAt(slot, angle, radius, pin) {
  const { angle: a, z } = slot;
  const last = a.length - 1;
  const past = radius * Math.max(angle - a[last], a[0] - angle);
  if (past >= pin * (1 - 1e-6)) return null;
  let k = 0;
  while (k < last - 1 && a[k + 1] < angle) k += 1;
  const slope = (z[k + 1] - z[k]) / (radius * Math.max(1e-9, a[k + 1] - a[k]));
  const centre = z[k] + slope * radius * (angle - a[k]); // beyond the ends: the tangent
  const half = pin * Math.hypot(1, slope);
  const reach = (pin * slope) / Math.hypot(1, slope) / radius; // from a centre to its point of the flank
  const circle = (end) => Math.sqrt(Math.max(0, pin * pin - (radius * (angle - a[end])) ** 2));
  const high = angle > a[last] - reach ? z[last] + circle(last) : angle < a[0] - reach ? z[0] + circle(0) : centre + half;
  const low = angle > a[last] + reach ? z[last] - circle(last) : angle < a[0] + reach ? z[0] - circle(0) : centre - half;
  return { low, high };
}

/** Angles of the columns over one turn, denser at the ends of the slots. */
function columnsOf(slots, radius, pin) {
  const start = slots[0].angle[0] - 1;
  const found = Array.from({ length: COLUMNS + 1 }, (_, k) => start + (2 * Math.PI * k) / COLUMNS);
  const reach = pin / radius;
  for (const { angle } of slots) {
    for (const end of [angle[0], angle[angle.length - 1]]) {
      for (let k = -END_COLUMNS; k <= END_COLUMNS; k += 1) found.push(end + reach * Math.sin((Math.PI * k) / END_COLUMNS / 2));
    }
  }
  const wrapped = found.map((x) => (x > start + 2 * Math.PI ? x - 2 * Math.PI : x < start ? x + 2 * Math.PI : x));
  return wrapped.sort((x, y) => x - y);
}

class Surface {
  positions = [];

  /** Two triangles. The corners are [angle, radius, z]. */
  quad(a, b, c, d) {
    for (const [angle, radius, z] of [a, b, c, a, c, d]) {
      this.positions.push(radius * Math.sin(angle), z, radius * Math.cos(angle));
    }
  }

  geometry() {
    const found = new BufferGeometry();
    found.setAttribute("position", new Float32BufferAttribute(this.positions, 3));
    found.computeVertexNormals();
    return found;
  }
}

/** Outward normals, so that the wall looks round although its triangles share no corner. */
function smooth(geometry, sign) {
  const p = geometry.getAttribute("position");
  const normal = geometry.getAttribute("normal");
  for (let k = 0; k < p.count; k += 1) {
    const length = Math.hypot(p.getX(k), p.getZ(k)) * sign;
    normal.setXYZ(k, p.getX(k) / length, 0, p.getZ(k) / length);
  }
  return geometry;
}

/**
 * A tube about the y axis. Angle 0 points to +z, positive angles turn towards +x.
 * @param {{outer: number, inner: number, low: number, high: number, slots: Slot[], pin: number}} shape
 * @returns {{outside: BufferGeometry, inside: BufferGeometry, flanks: BufferGeometry, rims: BufferGeometry,
 *   edges: BufferGeometry}} edges: line segments
 */
export function tube({ outer, inner, low, high, slots, pin }) {
  const columns = columnsOf(slots, outer, pin);
  const cuts = columns.map((angle) => slots.map((slot) => nearestTurn(slot, angle, outer, pin)).find((cut) => cut) ?? null);
  const [outside, inside, flanks, rims] = [new Surface(), new Surface(), new Surface(), new Surface()];
  const edges = [];
  const edge = (angle, other, z, zOther) => {
    for (const r of [outer, inner]) {
      edges.push(r * Math.sin(angle), z, r * Math.cos(angle), r * Math.sin(other), zOther, r * Math.cos(other));
    }
  };
  for (let k = 0; k + 1 < columns.length; k += 1) {
    const [a, b] = [columns[k], columns[k + 1]];
    if (b - a < 1e-7) continue;
    const pair = bounds(cuts[k], cuts[k + 1]);
    for (const [surface, r] of [[outside, outer], [inside, inner]]) {
      if (pair === null) surface.quad([a, r, low], [b, r, low], [b, r, high], [a, r, high]);
      else {
        surface.quad([a, r, low], [b, r, low], [b, r, pair.lowB], [a, r, pair.lowA]);
        surface.quad([a, r, pair.highA], [b, r, pair.highB], [b, r, high], [a, r, high]);
      }
    }
    if (pair !== null) {
      flanks.quad([a, inner, pair.lowA], [b, inner, pair.lowB], [b, outer, pair.lowB], [a, outer, pair.lowA]);
      flanks.quad([a, inner, pair.highA], [a, outer, pair.highA], [b, outer, pair.highB], [b, inner, pair.highB]);
      edge(a, b, pair.lowA, pair.lowB);
      edge(a, b, pair.highA, pair.highB);
    }
    for (const z of [low, high]) {
      rims.quad([a, inner, z], [b, inner, z], [b, outer, z], [a, outer, z]);
      edge(a, b, z, z);
    }
  }
  const lines = new BufferGeometry();
  lines.setAttribute("position", new Float32BufferAttribute(edges, 3));
  return {
    outside: smooth(outside.geometry(), 1),
    inside: smooth(inside.geometry(), -1),
    flanks: flanks.geometry(),
    rims: rims.geometry(),
    edges: lines,
  };
}

/** The cut at an angle, which may be meant one turn earlier or later. */
function nearestTurn(slot, angle, radius, pin) {
  for (const turn of [0, -2 * Math.PI, 2 * Math.PI]) {
    const cut = cutAt(slot, angle + turn, radius, pin);
    if (cut !== null) return cut;
  }
  return null;
}

/** The slot between two columns; where only one has it, the slot closes at the middle of that one. */
function bounds(a, b) {
  if (a === null && b === null) return null;
  const point = (cut) => (cut.low + cut.high) / 2;
  return {
    lowA: a?.low ?? point(b),
    highA: a?.high ?? point(b),
    lowB: b?.low ?? point(a),
    highB: b?.high ?? point(a),
  };
}
