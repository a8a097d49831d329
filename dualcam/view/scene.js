/** The mechanism in 3D: cams, pin, carriage, spring and the arrow of the torque. One unit is the outer radius. */
import {
  AmbientLight, Color, CylinderGeometry, DirectionalLight, DoubleSide, FrontSide, Group,
  HemisphereLight, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, PerspectiveCamera, Raycaster,
  Scene, Vector2, Vector3, WebGLRenderer,
} from "three";
import { Arc, Coil } from "dualcam/arrows";
import { colours } from "dualcam/chart";
import { tube } from "dualcam/tube";

const WALL = 0.1; // thickness of a tube
const PIN = 0.085; // radius
const MARGIN = 0.24; // from a groove to the rim
const LEAST_GAP = 0.14; // between the drawn radii
const STROKE = [0.45, 1.5]; // least and greatest drawn stroke
const CARRIAGE = 0.62; // from the pin to the top of the carriage at least
const ARC_Y = 0.24; // of the torque's arrow, below the tubes

/** Does WebGL draw without a GPU? Throws where there is no WebGL. */
function drawsInSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (gl === null) throw new Error("this browser has no WebGL 2");
  const facts = gl.getExtension("WEBGL_debug_renderer_info");
  const name = facts ? gl.getParameter(facts.UNMASKED_RENDERER_WEBGL) : "";
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

export class MechanismView {
  /** @param {HTMLCanvasElement} canvas; throws where there is no WebGL */
  constructor(canvas) {
    this.canvas = canvas;
    this.isSoftware = drawsInSoftware();
    this.renderer = new WebGLRenderer({ canvas, antialias: !this.isSoftware, powerPreference: "low-power" });
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(30, 1, 0.1, 100);
    this.direction = { azimuth: 0.5, height: 0.42, distance: 1 };
    this.quality = this.isSoftware ? 0.6 : 1;
    this.stillQuality = this.isSoftware ? 1.7 : 1; // of a picture that stands: more pixels in place of antialiasing
    this.raycaster = new Raycaster();
    this.lights();
    this.materials();
  }

  lights() {
    this.scene.add(new AmbientLight(0xffffff, 0.7), new HemisphereLight(0xffffff, 0x8a8a80, 1.3));
    const sun = new DirectionalLight(0xffffff, 1.9);
    sun.position.set(2, 4, 3);
    this.scene.add(sun);
  }

  materials() {
    const make = (options) => new MeshLambertMaterial({ side: DoubleSide, ...options });
    const glass = { transparent: true, opacity: 0.2, side: FrontSide, depthWrite: false };
    this.material = {
      solid: [make({}), make({})], // of cam 1 and cam 2
      glass: [make(glass), make(glass)],
      shade: [make({}), make({})], // inside of a solid tube
      dark: [make({}), make({})], // flanks of the grooves
      pin: make({}),
      carriage: make({}),
      spring: make({ side: FrontSide }),
      ground: make({ side: FrontSide }),
      line: [new LineBasicMaterial(), new LineBasicMaterial()],
      arrow: make({}),
    };
  }

  /** Colours of the theme. */
  paint() {
    const { material: m } = this;
    this.renderer.setClearColor(colours.stage);
    const [cam1, cam2] = [new Color(colours.cam1), new Color(colours.cam2)];
    [cam1, cam2].forEach((colour, k) => {
      m.solid[k].color.copy(colour).lerp(new Color(0xffffff), 0.14);
      m.shade[k].color.copy(colour).multiplyScalar(0.5);
      m.glass[k].color.copy(colour).lerp(new Color(0xffffff), 0.55);
      m.dark[k].color.copy(colour).multiplyScalar(0.3);
      m.line[k].color.copy(colour).multiplyScalar(0.75);
    });
    m.pin.color.set(colours.pin);
    m.carriage.color.set(colours.pin).lerp(new Color(colours.soft), 0.65);
    m.spring.color.set(colours.spring);
    m.ground.color.set(colours.line);
    m.arrow.color.set(colours.cam2);
  }

  /** Builds all parts for a shape of the mechanism. @param {import("dualcam/geometry").Shape} shape */
  build(shape) {
    this.shape = shape;
    this.measure(shape);
    this.dispose();
    this.parts = new Group();
    this.cam1 = this.makeCam(0);
    this.cam2 = this.makeCam(1);
    this.follower = this.makeFollower();
    this.coil = new Coil(this.material.spring, 0.3, 0.036);
    this.arc = new Arc(this.material.arrow, this.arcRadius);
    this.arc.group.position.y = this.arcY;
    this.parts.add(this.cam1, this.cam2, this.follower, this.coil.mesh, this.arc.group, this.makeGround());
    this.scene.add(this.parts);
    this.paint();
  }

  /** Drawn radii and lengths. Radii that are nearly equal are drawn apart. */
  measure({ radius, z }) {
    const outer = Math.max(...radius);
    this.outerCam = radius[1] >= radius[0] ? 1 : 0;
    const inner = Math.min(Math.min(...radius) / outer, 1 - WALL - LEAST_GAP);
    this.radius = this.outerCam === 1 ? [Math.max(0.3, inner), 1] : [1, Math.max(0.3, inner)];
    this.drawnApart = Math.abs(Math.max(0.3, inner) - Math.min(...radius) / outer) > 1e-9;
    const stroke = z[z.length - 1] - z[0];
    const drawn = Math.min(STROKE[1], Math.max(STROKE[0], stroke / outer));
    this.zScale = stroke > 1e-9 * outer ? drawn / stroke : 1 / outer; // flat grooves have no stroke to draw
    this.stretch = this.zScale * outer;
    this.zLow = z[0];
    this.stroke = stroke * this.zScale;
    this.low = -MARGIN - PIN;
    this.high = this.stroke + MARGIN + PIN;
    this.arcY = this.low - ARC_Y;
    this.arcRadius = this.outerCam === 1 ? 1 : this.radius[1];
    this.rod = Math.max(CARRIAGE, this.high + 0.12);
    this.ceiling = this.rod + this.stroke * 1.2 + 0.5;
    this.base = this.low - 2 * ARC_Y;
    this.middle = (this.ceiling + this.base) / 2;
  }

  drawnZ(z) {
    return (z - this.zLow) * this.zScale;
  }

  makeCam(k) {
    const { theta, gamma, z, contacts } = this.shape;
    const outer = this.radius[k];
    // Groove of cam 2 in its own frame: the pin is at the angle gamma - theta, which falls.
    const angle = k === 0 ? gamma : gamma.map((g, i) => g - theta[i]);
    const drawn = z.map((x) => this.drawnZ(x));
    const rising = angle[angle.length - 1] >= angle[0];
    const line = { angle: rising ? angle : [...angle].reverse(), z: rising ? drawn : [...drawn].reverse() };
    const turns = contacts === 2 && line.angle[line.angle.length - 1] - line.angle[0] < 2.6 ? [0, Math.PI] : [0];
    const slots = turns.map((turn) => ({ angle: line.angle.map((x) => x + turn), z: line.z }));
    const isOuter = k === this.outerCam;
    const low = isOuter ? this.low : this.low - 0.02;
    const high = isOuter ? this.high : this.high + 0.02;
    const surfaces = tube({ outer, inner: outer - WALL, low, high, slots, pin: PIN });
    const skin = isOuter ? this.material.glass[k] : this.material.solid[k];
    const group = new Group();
    for (const name of ["outside", "rims"]) group.add(new Mesh(surfaces[name], skin));
    group.add(new Mesh(surfaces.inside, isOuter ? skin : this.material.shade[k]));
    group.add(new Mesh(surfaces.flanks, this.material.dark[k]));
    group.add(new LineSegments(surfaces.edges, this.material.line[k]));
    if (isOuter) group.children.slice(0, 3).forEach((mesh) => (mesh.renderOrder = 2));
    group.add(this.makeFoot(k, low));
    return group;
  }

  /** What holds a cam: cam 1 stands on the ground; cam 2 has a collar with a pointer. */
  makeFoot(k, low) {
    const group = new Group();
    const r = this.radius[k];
    const foot = (top, bottom, y0, y1, material) => {
      const mesh = new Mesh(new CylinderGeometry(top, bottom, y1 - y0, 64, 1, true), material);
      mesh.position.y = (y0 + y1) / 2;
      group.add(mesh);
    };
    if (k === 0) foot(r - WALL / 2, r - WALL / 2, this.base, low, this.material.solid[0]);
    else {
      foot(r - WALL / 2, r - WALL / 2, this.arcY - 0.06, low, this.material.glass[1]);
      const pointer = new Mesh(new CylinderGeometry(0.035, 0.035, this.high - this.low, 12), this.material.solid[1]);
      pointer.position.set(r * Math.sin(0.9), (this.high + this.low) / 2, r * Math.cos(0.9));
      group.add(pointer);
    }
    return group;
  }

  makeFollower() {
    const group = new Group();
    const both = this.shape.contacts === 2;
    const length = both ? 2.16 : 1.08;
    const pin = new Mesh(new CylinderGeometry(PIN * 0.97, PIN * 0.97, length, 32), this.material.pin);
    pin.rotation.x = Math.PI / 2;
    pin.position.z = both ? 0 : length / 2;
    const rod = new Mesh(new CylinderGeometry(0.13, 0.13, this.rod, 32), this.material.carriage);
    rod.position.y = this.rod / 2;
    const plate = new Mesh(new CylinderGeometry(0.42, 0.42, 0.07, 48), this.material.carriage);
    plate.position.y = this.rod;
    group.add(pin, rod, plate);
    return group;
  }

  makeGround() {
    const group = new Group();
    const disc = (radius, y) => {
      const mesh = new Mesh(new CylinderGeometry(radius, radius, 0.06, 64), this.material.ground);
      mesh.position.y = y;
      group.add(mesh);
    };
    disc(1.18, this.base - 0.03);
    disc(0.55, this.ceiling + 0.03);
    return group;
  }

  /**
   * Moves the parts.
   * @param {{theta: number, gamma: number, z: number, torque: number}} now torque: share of the largest one
   */
  place({ theta, gamma, z, torque }) {
    const y = this.drawnZ(z);
    this.cam2.rotation.y = theta;
    this.follower.rotation.y = gamma;
    this.follower.position.y = y;
    this.coil.between(y + this.rod + 0.035, this.ceiling);
    this.arc.show(torque);
  }

  /** Points of the parts that have a name, in pixels, and the side of the picture on which the name stands. */
  labels() {
    const { gamma, z } = this.last;
    const y = this.drawnZ(z);
    const isOut = this.outerCam === 1; // is cam 2 outside?
    const edge = (side, radius, height) => {
      const angle = this.direction.azimuth + side;
      return new Vector3(radius * Math.sin(angle), height, radius * Math.cos(angle));
    };
    const places = {
      cam1: [edge(-0.9, this.radius[0], isOut ? this.high + 0.02 : 0.2), -1],
      cam2: isOut ? [edge(1.3, 1, 0.3 * this.high), 1] : [edge(0.9, this.radius[1], this.high + 0.02), 1],
      pin: [new Vector3(1.08 * Math.sin(gamma), y, 1.08 * Math.cos(gamma)), -1],
      spring: [edge(1.5, 0.32, (y + this.rod + this.ceiling) / 2), 1],
    };
    const { clientWidth: w, clientHeight: h } = this.canvas;
    const pixels = (place) => {
      place.project(this.camera);
      return [((place.x + 1) / 2) * w, ((1 - place.y) / 2) * h];
    };
    const [right] = pixels(edge(Math.PI / 2, 1.18, 0));
    this.radiusInPixels = (right - w / 2) / 1.18;
    const reach = Math.min(right - w / 2 + 12, w / 2 - 92);
    return Object.fromEntries(
      Object.entries(places).map(([name, [place, side]]) => [name, { point: pixels(place), side, x: w / 2 + side * reach }]),
    );
  }

  /** Puts the camera so far away that everything is in the picture. */
  aim() {
    const { azimuth, height, distance } = this.direction;
    const half = Math.tan((this.camera.fov * Math.PI) / 360);
    const [sin, cos] = [Math.sin(height), Math.cos(height)];
    let far = 0;
    for (const [radius, y] of [[1.18, this.base - 0.06], [0.55, this.ceiling + 0.06], [1, this.high]]) {
      const rise = y - this.middle;
      for (const front of [-radius, radius]) {
        far = Math.max(far, sin * rise + cos * front + Math.abs(cos * rise - sin * front) / half);
      }
      far = Math.max(far, sin * rise + radius / (half * this.camera.aspect));
    }
    const reach = far * 1.03 * distance;
    this.camera.position.set(cos * reach * Math.sin(azimuth), this.middle + sin * reach, cos * reach * Math.cos(azimuth));
    this.camera.lookAt(0, this.middle, 0);
  }

  /** @param {object} now as place() takes it @param {number} quality share of the screen's pixels in each direction */
  draw(now, quality) {
    this.last = now;
    const { clientWidth: w, clientHeight: h } = this.canvas;
    if (w < 20 || h < 20) return;
    const ratio = Math.min(2, window.devicePixelRatio || 1) * quality;
    const size = this.renderer.getSize(new Vector2());
    if (size.x !== w || size.y !== h || this.renderer.getPixelRatio() !== ratio) {
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(w, h, false);
      this.camera.aspect = w / h;
      this.camera.updateProjectionMatrix();
    }
    this.aim();
    this.place(now);
    this.renderer.render(this.scene, this.camera);
  }

  /** Is cam 2 under the pointer? Coordinates from -1 to 1. */
  hitsCam2(x, y) {
    this.raycaster.setFromCamera(new Vector2(x, y), this.camera);
    const hits = this.raycaster.intersectObjects([this.cam1, this.cam2, this.follower], true);
    const first = hits.find((hit) => hit.object.isMesh);
    if (!first) return false;
    for (let part = first.object; part; part = part.parent) if (part === this.cam2 || part === this.follower) return true;
    return this.outerCam === 0; // the outer cam 1 hides cam 2: dragging turns cam 2 all the same
  }

  dispose() {
    if (!this.parts) return;
    this.scene.remove(this.parts);
    this.parts.traverse((part) => part.geometry?.dispose());
  }
}
