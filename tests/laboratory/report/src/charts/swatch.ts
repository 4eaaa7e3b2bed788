// The mark of a line beside its name: a stroke with the symbol, hollow and dashed where the line is.
import * as Plot from '@observablehq/plot';

export interface SwatchStyle { colour: string; symbol: Plot.SymbolType; solid: boolean }

const drawn = new Map<string, Element>();

function draw({ colour, symbol, solid }: SwatchStyle): Element {
  const picture = Plot.plot({
    width: 28, height: 12, margin: 0, className: 'swatch', x: { domain: [0, 1], axis: null }, y: { domain: [0, 1], axis: null },
    marks: [Plot.ruleY([0.5], { stroke: colour, strokeWidth: solid ? 2.3 : 1.5, ...(!solid && { strokeDasharray: '4 3' }) }),
      Plot.dot([[0.5, 0.5]], { symbol, r: 3.8, stroke: colour, strokeWidth: 1.4, fill: solid ? colour : 'var(--card)' })],
  });
  picture.setAttribute('aria-hidden', 'true');
  return picture;
}

export function swatch({ colour, symbol, solid }: SwatchStyle): Node {
  const key = `${colour} ${String(symbol)} ${solid}`;
  if (!drawn.has(key)) drawn.set(key, draw({ colour, symbol, solid }));
  return drawn.get(key)!.cloneNode(true);
}
