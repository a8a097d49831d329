/** Torque over the angle: the stick band, the point of the present state and its trail. */
import { Chart, colours } from "dualcam/chart";
import { text } from "dualcam/units";

const DEGREE = 180 / Math.PI;
const MOST_BANDS = 8; // the chart reaches this many times the height of the stick band beyond the band

export class TorqueChart {
  constructor(canvas) {
    this.canvas = canvas;
    this.chart = new Chart(canvas);
    this.band = null;
  }

  /**
   * @param {{theta: number[], load: number[], release: number[]}} band
   * @param {number} scale largest torque of the band [N.m]
   */
  setBand(band, scale) {
    this.band = band;
    const edges = [...band.load, ...band.release].filter(Number.isFinite);
    const low = Math.min(0, ...edges);
    const high = Math.max(scale * 0.2, ...edges);
    const room = 0.18 * (high - low);
    this.least = [low - (low < 0 ? room : 0.08 * (high - low)), high + room];
    this.rangeX = [band.theta[0] * DEGREE, band.theta[band.theta.length - 1] * DEGREE];
  }

  draw(player) {
    const { chart, band } = this;
    if (band === null || !chart.begin()) return;
    const theta = player.engine.get("theta") * DEGREE;
    const tau = player.engine.get("tau");
    const [x0, x1] = this.rangeX;
    const room = 0.04 * (x1 - x0);
    chart.ranges([x0 - room, x1 + room], this.rangeY(player.extremes));
    chart.axes("angle theta [deg]", "torque tau [N.m]");
    chart.clip();
    this.drawBand();
    this.drawTrail(player.trail);
    chart.dot(theta, tau, 6, colours.pin);
    chart.unclip();
    this.canvas.setAttribute(
      "aria-label",
      `Torque over the angle. Angle ${text(theta)} degrees, torque ${text(tau)} newton metres.`,
    );
  }

  /** The band's range, wider where the torque has left the band, up to some times the band. */
  rangeY([least, most]) {
    const [low, high] = this.least;
    const room = 0.05 * (high - low);
    const beyond = MOST_BANDS * (high - low);
    return [
      Math.min(low, Math.max(least, low - beyond) - room),
      Math.max(high, Math.min(most, high + beyond) + room),
    ];
  }

  drawBand() {
    const { chart, band } = this;
    const { context: c } = chart;
    const [low, high] = chart.y;
    const far = (y) => (y > high ? high + 1 : y < low ? low - 1 : y) || 0;
    c.beginPath();
    band.theta.forEach((x, k) => c.lineTo(chart.px(x * DEGREE), chart.py(far(band.load[k]))));
    for (let k = band.theta.length - 1; k >= 0; k -= 1) {
      c.lineTo(chart.px(band.theta[k] * DEGREE), chart.py(far(band.release[k])));
    }
    c.closePath();
    c.fillStyle = colours.band;
    c.fill();
    c.lineWidth = 2;
    const curve = (edge) => band.theta.map((x, k) => [x * DEGREE, edge[k]]);
    c.strokeStyle = colours.cam2;
    chart.line(curve(band.load));
    c.strokeStyle = colours.cam1;
    chart.line(curve(band.release));
    c.strokeStyle = colours.soft;
    c.lineWidth = 1;
    chart.line([[chart.x[0], 0], [chart.x[1], 0]]);
    this.name("load", band.load, colours.cam2, -12);
    this.name("release", band.release, colours.cam1, 13);
    this.nameBand();
  }

  /** The edge's name above or below its middle. */
  name(word, edge, colour, offset) {
    const { chart, band } = this;
    const k = Math.round(0.62 * (band.theta.length - 1));
    if (!Number.isFinite(edge[k])) return;
    chart.words(word, chart.px(band.theta[k] * DEGREE), chart.py(edge[k]) + offset, colour, offset < 0 ? "right" : "left");
  }

  nameBand() {
    const { chart, band } = this;
    const k = Math.round(0.82 * (band.theta.length - 1));
    const [top, bottom] = [band.load[k], band.release[k]].map((y) => Math.min(chart.y[1], Math.max(chart.y[0], y)));
    if ((top - bottom) * chart.ky > 26) {
      chart.words("stick band", chart.px(band.theta[k] * DEGREE), chart.py((top + bottom) / 2), colours.soft, "center");
    }
  }

  drawTrail(trail) {
    const { context: c } = this.chart;
    const stride = Math.max(1, Math.floor(trail.length / 700));
    const points = trail.filter((_, k) => k % stride === 0 || k === trail.length - 1);
    c.lineWidth = 2;
    c.strokeStyle = colours.trail;
    this.chart.line(points.map(([theta, tau]) => [theta * DEGREE, tau]));
  }
}
