/** Mouse, touch and keys on the 3D view: orbit, zoom, and turning cam 2 by hand. */
import { clamp, fixed } from "dualcam/units";

const RADIANS_PER_PIXEL = 0.008; // of the view
const KEY_TURN = 0.06; // rad of the view for each key press
const HAND_SPEED = 0.02; // rad of the hand for each repetition of a key

export class Pointer {
  /**
   * @param {import("dualcam/scene").MechanismView} view
   * @param {import("dualcam/player").Player} player
   * @param {() => void} changed asks for a new picture
   */
  constructor(view, player, changed) {
    Object.assign(this, { view, player, changed });
    const { canvas } = view;
    this.pointers = new Map();
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
      canvas.addEventListener(name, (event) => this.up(event));
    }
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("keydown", (event) => this.key(event));
    document.addEventListener("keydown", (event) => this.handKey(event));
    document.addEventListener("keyup", (event) => this.releaseKey(event));
  }

  position(event) {
    const box = this.view.canvas.getBoundingClientRect();
    return [(2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height];
  }

  down(event) {
    const { view, player } = this;
    view.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
    this.turns = this.pointers.size === 1 && event.button === 0 && view.hitsCam2(...this.position(event));
    if (this.turns) {
      player.hold(player.engine.get("theta"));
      view.canvas.classList.add("turning");
    } else player.letGo();
  }

  move(event) {
    const last = this.pointers.get(event.pointerId);
    if (last === undefined) return;
    const [dx, dy] = [event.clientX - last[0], event.clientY - last[1]];
    const before = this.spread();
    this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const { direction } = this.view;
    if (this.pointers.size === 2) direction.distance = clamp(direction.distance * (before / this.spread()), 0.4, 2.5);
    else if (this.turns && this.player.hand !== null) this.player.moveHand(dx / this.view.radiusInPixels);
    else {
      direction.azimuth -= dx * RADIANS_PER_PIXEL;
      direction.height = clamp(direction.height + dy * RADIANS_PER_PIXEL, -0.4, 1.45);
    }
    this.changed();
  }

  /** Distance between two fingers in pixels. */
  spread() {
    const [a, b] = [...this.pointers.values()];
    return b === undefined ? 1 : Math.max(1, Math.hypot(a[0] - b[0], a[1] - b[1]));
  }

  up(event) {
    if (!this.pointers.delete(event.pointerId) || !this.turns) return;
    this.turns = false;
    this.player.letGo();
    this.view.canvas.classList.remove("turning");
    this.changed();
  }

  /** Zoom where the view has the focus or Ctrl is held, so that the page scrolls past the picture. */
  wheel(event) {
    if (document.activeElement !== this.view.canvas && !event.ctrlKey) return;
    event.preventDefault();
    this.zoom(Math.exp(event.deltaY * 0.001));
  }

  zoom(factor) {
    const { direction } = this.view;
    direction.distance = clamp(direction.distance * factor, 0.4, 2.5);
    this.changed();
  }

  key(event) {
    const { direction } = this.view;
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (turns !== undefined) {
      direction.azimuth += turns[0] * KEY_TURN;
      direction.height = clamp(direction.height + turns[1] * KEY_TURN, -0.4, 1.45);
    } else if (event.key === "+" || event.key === "=") this.zoom(0.92);
    else if (event.key === "-") this.zoom(1.08);
    else return;
    event.preventDefault();
    this.changed();
  }

  handKey(event) {
    const way = { a: -1, d: 1 }[event.key.toLowerCase()];
    if (way === undefined || event.ctrlKey || event.metaKey || event.altKey || isTyping(event.target)) return;
    const { player } = this;
    if (player.hand === null) player.hold(player.engine.get("theta"));
    player.moveHand(way * HAND_SPEED);
    this.byKey = true;
  }

  releaseKey(event) {
    if (!this.byKey || !["a", "d"].includes(event.key.toLowerCase())) return;
    this.byKey = false;
    this.player.letGo();
  }
}

/** Does the element take letters? */
export function isTyping(target) {
  return target instanceof Element && target.matches("input[type=number], select, textarea");
}

/** What the hand does, in words. */
export function handWords(player) {
  return `Your hand: ${fixed(player.handTorque(), 2)} N.m`;
}
