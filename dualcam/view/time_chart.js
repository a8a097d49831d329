/** Angle and torque over the last seconds. */
import { Chart, colours } from "dualcam/chart";
import { text } from "dualcam/units";

const DEGREE = 180 / Math.PI;

export class TimeChart {
  constructor(canvas) {
    this.chart = new Chart(canvas, { right: 44 });
  }

  draw(player, rangeTheta, rangeTau) {
    const { chart } = this;
    if (!chart.begin()) return;
    const now = player.time;
    const trail = player.trail;
    const start = trail.length ? trail[0][2] : 0;
    const stride = Math.max(1, Math.floor(trail.length / 600));
    const points = trail.filter((_, k) => k % stride === 0 || k === trail.length - 1);
    const times = [Math.max(start, now - 3), Math.max(start, now - 3) + Math.max(0.5, Math.min(3, now - start))];
    this.curve(points, times, rangeTau, colours.trail, ([, tau]) => tau, "right", "torque [N.m]");
    this.curve(points, times, rangeTheta, colours.cam2, ([theta]) => theta * DEGREE, "left", "angle [deg]");
  }

  curve(points, times, range, colour, value, side, label) {
    const { chart } = this;
    chart.ranges(times, range);
    if (side === "left") chart.axes("time [s]", "");
    chart.clip();
    chart.context.lineWidth = 2;
    chart.context.strokeStyle = colour;
    chart.line(points.map((point) => [point[2], value(point)]));
    chart.unclip();
    const left = side === "left";
    chart.words(label, left ? 2 : chart.width - 2, chart.margins.top - 12, colour, left ? "left" : "right");
    if (!left) {
      for (const y of [range[0], (range[0] + range[1]) / 2, range[1]]) {
        chart.words(text(y, 2), chart.width - chart.margins.right + 5, chart.py(y) + (y === range[1] ? 6 : 0), colour);
      }
    }
  }
}
