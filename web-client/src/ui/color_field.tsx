// A linear colour: a swatch to pick by eye, and its numbers, which may exceed 1.

import type { Vec3 } from "../core/vector";
import { useLooseDrag } from "./binding";
import { type FieldProps, VectorField } from "./fields";
import { Row } from "./row";

const linearFromSrgb = (c: number) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
const srgbFromLinear = (c: number) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);

/** Color as fields of the browser write it: "#rrggbb" in sRGB. */
export function hexOf(color: Vec3): string {
  const byte = (c: number) => Math.round(srgbFromLinear(Math.min(Math.max(c, 0), 1)) * 255);
  return `#${color.map((c) => byte(c).toString(16).padStart(2, "0")).join("")}`;
}

function linearOf(hex: string): Vec3 {
  const channel = (at: number) => linearFromSrgb(Number.parseInt(hex.slice(at, at + 2), 16) / 255);
  return [channel(1), channel(3), channel(5)];
}

export function ColorField(props: FieldProps<Vec3>) {
  const { label, doc, value, binding, disabled } = props;
  const drag = useLooseDrag(binding);
  return (
    <>
      <Row {...props}>
        <input
          type="color"
          aria-label={`${label} swatch`}
          title={doc}
          disabled={disabled}
          value={hexOf(value)}
          onInput={(event) => drag.update(linearOf(event.currentTarget.value))}
          onChange={() => drag.commit()}
        />
      </Row>
      <VectorField
        {...props}
        label={`${label} RGB`}
        reset={undefined}
        step={0.01}
        tags={["R", "G", "B"]}
        clamp={(channel) => Math.max(channel, 0)}
      />
    </>
  );
}
