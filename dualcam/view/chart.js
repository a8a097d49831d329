/** A chart on a canvas: axes with ticks, curves, arrows. Colours come from the style sheet. */
import { text } from "dualcam/units";

/** Round distance between two ticks for about `count` of them. */
export function tickDistance(span, count) {
  const raw = span / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].find((x) => x * power >= raw * 0.999);
  return step * power;
}

/** The colours of the style sheet, read anew when the theme changes. */
export const colours = {};
export function readColours() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["text", "soft", "line", "panel", "cam1", "cam2", "pin", "spring", "band", "trail", "bad", "stage"]) {
    colours[name] = style.getPropertyValue(`--${name}`).trim();
  }
}

export class Chart {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas, margins = {}) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.margins = { left: 46, right: 12, top: 24, bottom: 34, ...margins };
  }

  /** Fit the canvas to its box; returns false where the box is hidden. */
  begin() {
    const { canvas, context } = this;
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    const width = canvas.clientWidth;
    const height = canvas.clientHeight;
    if (width < 40 || height < 40) return false;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = "12px system-ui, sans-serif";
    context.lineJoin = "round";
    context.lineCap = "round";
    this.width = width;
    this.height = height;
    return true;
  }

  /**
   * Ranges of the axes.
   * @param {[number, number]} x
   * @param {[number, number]} y
   * @param {boolean} [equal] one scale for both, for shapes
   */
  ranges(x, y, equal = false) {
    const { left, right, top, bottom } = this.margins;
    const [w, h] = [this.width - left - right, this.height - top - bottom];
    this.x = [...x];
    this.y = [...y];
    if (equal) {
      const scale = Math.min(w / (x[1] - x[0]), h / (y[1] - y[0]));
      const [mx, my] = [(x[0] + x[1]) / 2, (y[0] + y[1]) / 2];
      this.x = [mx - w / scale / 2, mx + w / scale / 2];
      this.y = [my - h / scale / 2, my + h / scale / 2];
    }
    this.kx = w / (this.x[1] - this.x[0]);
    this.ky = h / (this.y[1] - this.y[0]);
  }

  px(x) {
    return this.margins.left + (x - this.x[0]) * this.kx;
  }

  py(y) {
    return this.height - this.margins.bottom - (y - this.y[0]) * this.ky;
  }

  /** Frame, grid and ticks with their words. */
  axes(labelX, labelY) {
    const { context: c, margins: m } = this;
    const [w, h] = [this.width - m.left - m.right, this.height - m.top - m.bottom];
    c.lineWidth = 1;
    c.strokeStyle = colours.line;
    c.fillStyle = colours.soft;
    c.textAlign = "center";
    c.textBaseline = "top";
    for (const x of ticks(this.x, w / 70)) {
      this.line([[x, this.y[0]], [x, this.y[1]]]);
      c.fillText(text(x), this.px(x), this.height - m.bottom + 4);
    }
    c.textAlign = "right";
    c.textBaseline = "middle";
    for (const y of ticks(this.y, h / 42)) {
      this.line([[this.x[0], y], [this.x[1], y]]);
      c.fillText(text(y), m.left - 5, this.py(y));
    }
    c.textAlign = "right";
    c.textBaseline = "bottom";
    c.fillText(labelX, this.width - m.right, this.height - 1);
    c.textAlign = "left";
    c.fillText(labelY, 2, m.top - 6);
  }

  /** A path through points [x, y]; those that are not finite interrupt the path. */
  line(points, toPixels = true) {
    const { context: c } = this;
    c.beginPath();
    let pen = false;
    for (const [x, y] of points) {
      if (!Number.isFinite(x) || !Number.isFinite(y)) pen = false;
      else {
        const [u, v] = toPixels ? [this.px(x), this.py(y)] : [x, y];
        if (pen) c.lineTo(u, v);
        else c.moveTo(u, v);
        pen = true;
      }
    }
    c.stroke();
  }

  /** What is drawn next stays inside the axes. */
  clip() {
    const { context: c, margins: m } = this;
    c.save();
    c.beginPath();
    c.rect(m.left, m.top, this.width - m.left - m.right, this.height - m.top - m.bottom);
    c.clip();
  }

  unclip() {
    this.context.restore();
  }

  dot(x, y, radius, colour) {
    const { context: c } = this;
    c.beginPath();
    c.arc(this.px(x), this.py(y), radius, 0, 2 * Math.PI);
    c.fillStyle = colour;
    c.fill();
    c.lineWidth = 1.5;
    c.strokeStyle = colours.panel;
    c.stroke();
  }

  /** An arrow in pixels from (u, v), by (du, dv), v downwards. */
  arrow(u, v, du, dv, colour, width = 2) {
    const length = Math.hypot(du, dv);
    if (length < 2) return;
    const { context: c } = this;
    const [ex, ey] = [du / length, dv / length];
    const head = Math.min(9, 0.6 * length);
    c.strokeStyle = colour;
    c.fillStyle = colour;
    c.lineWidth = width;
    c.beginPath();
    c.moveTo(u, v);
    c.lineTo(u + du - ex * head * 0.8, v + dv - ey * head * 0.8);
    c.stroke();
    c.beginPath();
    c.moveTo(u + du, v + dv);
    c.lineTo(u + du - ex * head - ey * head * 0.45, v + dv - ey * head + ex * head * 0.45);
    c.lineTo(u + du - ex * head + ey * head * 0.45, v + dv - ey * head - ex * head * 0.45);
    c.closePath();
    c.fill();
  }

  words(what, u, v, colour, align = "left") {
    const { context: c } = this;
    c.fillStyle = colour;
    c.textAlign = align;
    c.textBaseline = "middle";
    c.fillText(what, u, v);
  }
}

function ticks([low, high], count) {
  const distance = tickDistance(high - low, count);
  const found = [];
  for (let k = Math.ceil(low / distance - 1e-9); k * distance <= high + 1e-9 * distance; k += 1) {
    found.push(Number((k * distance).toPrecision(12)));
  }
  return found;
}
