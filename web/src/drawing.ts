/** The string from the top to the bit: how its torque travels, and how its ends turn. */

import { colour } from "./traces";

const MARGIN = 26;

function size(canvas: HTMLCanvasElement): readonly [CanvasRenderingContext2D, number, number] | null {
  const context = canvas.getContext("2d");
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (!context || width === 0 || height === 0) {
    return null;
  }
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return [context, width, height];
}

function disk(context: CanvasRenderingContext2D, x: number, y: number, radius: number, angle: number): void {
  context.beginPath();
  context.ellipse(x, y, radius, radius * 0.4, 0, 0, 2 * Math.PI);
  context.stroke();
  context.beginPath();
  context.moveTo(x, y);
  context.lineTo(x + radius * Math.cos(angle), y + 0.4 * radius * Math.sin(angle));
  context.stroke();
}

export interface Ends {
  readonly top: number;
  readonly bit: number;
  readonly stuck: boolean;
}

/** Draw the torque from top to bit as the way a line stands off the string, and its ends at their angles [rad]. */
export function draw(canvas: HTMLCanvasElement, torque: Float64Array, most: number, ends: Ends): void {
  const sized = size(canvas);
  if (!sized) {
    return;
  }
  const [context, width, height] = sized;
  const style = getComputedStyle(document.documentElement);
  const x = width * 0.34;
  const reach = width - x - 8;
  const length = height - 2 * MARGIN;
  const at = (station: number): number => MARGIN + (length * station) / (torque.length - 1);
  context.lineWidth = 1;
  context.strokeStyle = colour(style, "--soft");
  context.beginPath();
  context.moveTo(x, MARGIN);
  context.lineTo(x, height - MARGIN);
  context.stroke();
  context.beginPath();
  torque.forEach((value, station) => {
    const out = x + (reach * Math.max(-0.4, Math.min(1, value / most)));
    if (station === 0) {
      context.moveTo(out, at(station));
    } else {
      context.lineTo(out, at(station));
    }
  });
  context.strokeStyle = colour(style, "--accent");
  context.lineWidth = 2;
  context.stroke();
  context.lineTo(x, height - MARGIN);
  context.lineTo(x, MARGIN);
  context.globalAlpha = 0.25;
  context.fillStyle = colour(style, "--accent");
  context.fill();
  context.globalAlpha = 1;
  context.lineWidth = 2;
  context.strokeStyle = colour(style, "--ink");
  disk(context, x, MARGIN, 18, ends.top);
  context.strokeStyle = colour(style, ends.stuck ? "--bad" : "--ink");
  disk(context, x, height - MARGIN, 18, ends.bit);
  context.fillStyle = colour(style, "--ink");
  context.font = "12px system-ui, sans-serif";
  context.textAlign = "center";
  const label = (text: string, y: number): void => context.fillText(text, Math.max(x, 0.5 * context.measureText(text).width + 1), y);
  label("top", 12);
  label(ends.stuck ? "bit, stuck" : "bit", height - 4);
}
