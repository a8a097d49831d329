/** Moving parts of the 3D view whose shape changes: the spring's coil and the arrow of the torque. */
import { BufferGeometry, ConeGeometry, Curve, Group, Mesh, TubeGeometry, Vector3 } from "three";

const TURNS = 6.5;

/** A helix of height 1 about the y axis. */
class Helix extends Curve {
  constructor(radius) {
    super();
    this.radius = radius;
  }

  getPoint(t, target = new Vector3()) {
    const angle = 2 * Math.PI * TURNS * t;
    return target.set(this.radius * Math.cos(angle), t, this.radius * Math.sin(angle));
  }
}

/** A coil spring. Its wire stays round: the centre line is stretched, the offsets of the wire are not. */
export class Coil {
  constructor(material, radius, wire) {
    const curve = new Helix(radius);
    const around = 8;
    const along = Math.round(TURNS * 26);
    const model = new TubeGeometry(curve, along, wire, around, false);
    this.centres = Array.from({ length: along + 1 }, (_, k) => k / along);
    this.around = around + 1;
    this.offsets = model.getAttribute("position").array.slice();
    this.centres.forEach((t, k) => {
      for (let j = 0; j < this.around; j += 1) this.offsets[3 * (k * this.around + j) + 1] -= curve.getPointAt(t).y;
    });
    this.heights = this.centres.map((t) => curve.getPointAt(t).y);
    this.mesh = new Mesh(model, material);
  }

  /** Stretches the coil from y = low to y = high. */
  between(low, high) {
    const position = this.mesh.geometry.getAttribute("position");
    this.heights.forEach((t, k) => {
      const y = low + t * (high - low);
      for (let j = 0; j < this.around; j += 1) {
        const n = k * this.around + j;
        position.array[3 * n + 1] = this.offsets[3 * n + 1] + y;
      }
    });
    position.needsUpdate = true;
  }
}

const SEGMENTS = 48;
const LONGEST = 1.5 * Math.PI; // of the arrow at the largest torque

/** An arc about the y axis with a head, as long as the torque is large. */
export class Arc {
  constructor(material, radius) {
    this.radius = radius + 0.12;
    this.group = new Group();
    this.shaft = new Mesh(new BufferGeometry(), material);
    this.head = new Mesh(new ConeGeometry(0.085, 0.22, 20), material);
    this.group.add(this.shaft, this.head);
    this.indices = SEGMENTS * 6 * 6;
    this.shaft.geometry = this.makeArc();
  }

  makeArc() {
    const radius = this.radius;
    class Circle extends Curve {
      getPoint(t, target = new Vector3()) {
        const angle = LONGEST * t - LONGEST / 2;
        return target.set(radius * Math.sin(angle), 0, radius * Math.cos(angle));
      }
    }
    return new TubeGeometry(new Circle(), SEGMENTS, 0.03, 6, false);
  }

  /** @param {number} share of the largest torque, from -1 to 1 */
  show(share) {
    const size = Math.min(1, Math.abs(share));
    this.group.visible = size > 0.01;
    this.shaft.geometry.setDrawRange(0, Math.round(SEGMENTS * size) * 36);
    const sign = Math.sign(share) || 1;
    this.group.scale.x = sign;
    const end = LONGEST * (Math.round(SEGMENTS * size) / SEGMENTS - 0.5);
    this.head.position.set(this.radius * Math.sin(end), 0, this.radius * Math.cos(end));
    this.head.rotation.set(0, 0, 0);
    this.head.rotateY(end);
    this.head.rotateZ(-Math.PI / 2);
  }
}

