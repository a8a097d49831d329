/** The unwrapped groove of one cam with the pin and the forces of the groove on the pin. */
import { Chart, colours } from "dualcam/chart";
import { text } from "dualcam/units";

const FRICTION_SCALE = 4; // the arrow of friction is drawn longer than that of the normal force

export class GrooveChart {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {1 | 2} number of the cam
   */
  constructor(canvas, number) {
    this.canvas = canvas;
    this.chart = new Chart(canvas, { left: 38, bottom: 32 });
    this.number = number;
    this.curve = null;
  }

  /**
   * @param {{x: number[], z: number[], slope: number[]}} curve of the pin's centre [mm]
   * @param {number} pin radius as drawn [mm]
   * @param {number} reaction scale of the arrows [N]
   */
  setCurve(curve, pin, reaction) {
    this.curve = curve;
    this.pin = pin;
    this.scale = reaction;
  }

  /** @param {{x: number, z: number, slope: number, reaction: number, friction: number, sigma: number}} now */
  draw(now) {
    const { chart, curve, pin } = this;
    if (curve === null || !chart.begin()) return;
    const colour = this.number === 1 ? colours.cam1 : colours.cam2;
    const room = 2.2 * pin;
    const last = curve.x.length - 1;
    chart.ranges([curve.x[0] - room, curve.x[last] + room], [curve.z[0] - room, curve.z[last] + room], true);
    chart.axes("along the circumference [mm]", "z [mm]");
    chart.clip();
    this.drawGroove(colour);
    this.drawPin(now);
    chart.unclip();
    this.drawForces(now, colour);
    this.canvas.setAttribute(
      "aria-label",
      `Unwrapped groove of cam ${this.number}. Reaction of one contact ${text(now.reaction)} newton.`,
    );
  }

  drawGroove(colour) {
    const { chart, curve, pin } = this;
    const { context: c } = chart;
    const points = curve.x.map((x, k) => [x, curve.z[k]]);
    const width = 2 * pin * chart.kx;
    const stroke = (lineWidth, style, alpha) => {
      Object.assign(c, { lineWidth, strokeStyle: style, globalAlpha: alpha });
      chart.line(points);
    };
    stroke(width + 3, colour, 1); // the flanks are what the narrower strokes leave of this one
    stroke(width, colours.panel, 1);
    stroke(width, colour, 0.2);
    c.setLineDash([5, 4]);
    stroke(1, colour, 1);
    c.setLineDash([]);
  }

  drawPin({ x, z }) {
    const { chart, pin } = this;
    const { context: c } = chart;
    c.beginPath();
    c.arc(chart.px(x), chart.py(z), pin * chart.kx, 0, 2 * Math.PI);
    c.fillStyle = colours.pin;
    c.fill();
  }

  /** Normal force of the flank on the pin and, in slip, friction against the motion. */
  drawForces({ x, z, slope, reaction, friction, sigma }, colour) {
    const { chart, pin } = this;
    const longest = Math.min(0.36 * chart.height, 110);
    const length = Math.min(1.3, Math.abs(reaction) / this.scale) * longest * Math.sign(reaction);
    const h = Math.hypot(1, slope);
    const [nx, nz] = [-slope / h, 1 / h];
    const [u, v] = [chart.px(x), chart.py(z)];
    const edge = pin * chart.kx * Math.sign(reaction);
    if (Math.abs(length) < 2) return;
    chart.arrow(u - nx * (edge + length), v + nz * (edge + length), nx * length, -nz * length, colours.text, 2.5);
    const words = `N ${text(reaction, 3)} N`;
    const drag = -sigma * FRICTION_SCALE * friction * Math.abs(length); // along the groove, at the flank
    if (sigma !== 0) chart.arrow(u - nx * edge, v + nz * edge, drag / h, (-drag * slope) / h, colours.bad, 2.5);
    chart.words(words, chart.width - 14, chart.height - chart.margins.bottom - 24, colours.text, "right");
    chart.words(
      sigma === 0 ? "friction: not unique" : `friction ${text(Math.abs(friction * reaction), 3)} N (arrow x ${FRICTION_SCALE})`,
      chart.width - 14,
      chart.height - chart.margins.bottom - 9,
      sigma === 0 ? colours.soft : colours.bad,
      "right",
    );
    chart.words(`cam ${this.number}`, chart.width - 14, chart.margins.top - 12, colour, "right");
  }
}
