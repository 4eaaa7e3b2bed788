// The maximum of independent variables: the probability of each to be it, and its expected value, by integration downwards over one
// grid of adaptive steps that all share, as engine_client/math/maximum.h has it. Deterministic. Error of a probability: 1e-6.
// Cost: some 40 points for variables of similar width, and one exponential per variable and point.

/** A density is nothing where its logarithm is this far below its peak. */
export const NEGLIGIBLE = -28;

/** The logarithm of a density, a concave function, at a point: relative to its peak, its slope and its curvature (< 0). */
export interface LogDensity { relative: number; slope: number; curvature: number }
/** The value as a function of the axis t: itself, dv/dt, and the derivatives of ln(dv/dt). */
export interface ValueScale { value: number; rate: number; slope: number; curvature: number }

/** Variables on a common axis, each with one peak. Outside [low, high] the density is negligible; low < high. */
export interface Variables {
  readonly supports: readonly { low: number; high: number; logPeak: number }[];
  /** Sets the point that scale and at are about. */
  moveTo(t: number): void;
  scale(): ValueScale;
  at(variable: number): LogDensity;
}

export interface Maximum { probability: number[]; expectedValue: number }

const STEP = 0.5; // in units of the densities' own scale
const SLOPE_WEIGHT = 0.5; // an exponential tail needs steps of 0.7 of its scale where its mass is
const NO_PROBABILITY = 1e-12;

// A function's value and first two derivatives.
interface Jet { value: number; first: number; second: number }
const jet = (value: number, slope: number, curvature: number): Jet =>
  ({ value, first: value * slope, second: value * (slope * slope + curvature) });

// The integral between two points by Hermite's rule, exact for polynomials of degree 5.
const between = (left: Jet, right: Jet, width: number) =>
  width * ((left.value + right.value) / 2 + (width * (left.first - right.first)) / 10 + (width * width * (left.second + right.second)) / 120);

class Variable {
  log: LogDensity = { relative: 0, slope: 0, curvature: -1 };
  density: Jet = jet(0, 0, 0);
  ratio = 0; // density ÷ P(below t)
  ratioSlope = 0;
  win: Jet = jet(0, 0, 0); // density of being the maximum
  above = 0; // P(above t)
  probability = 0; // P(the maximum, and above t)
  constructor(readonly index: number, readonly high: number, readonly logPeak: number) {}
}

class Integral {
  private readonly variables: Variable[]; // the highest end first
  private joined = 0; // how many have their high end at t or above
  private t: number;
  private readonly end: number; // the highest low end: some variable is certainly above it
  private allBelow = 1; // P(all are below t)
  private shortfall: Jet = jet(0, 0, 0); // P(some is above) · dv/dt
  private valueAbove = 0; // its integral from t upwards

  constructor(private readonly source: Variables) {
    this.variables = source.supports.map(({ high, logPeak }, index) => new Variable(index, high, logPeak));
    this.variables.sort((a, b) => b.high - a.high);
    this.t = this.variables[0]!.high;
    this.end = Math.max(...source.supports.map(({ low }) => low));
    source.moveTo(this.t);
    this.join();
    this.updateWins(0);
  }

  private get active(): Variable[] { return this.variables.slice(0, this.joined); }

  // Adds the variables whose high end is here. They come in after the interval above, for whose width they change too fast.
  private join(): boolean {
    const before = this.joined;
    while (this.joined < this.variables.length && this.variables[this.joined]!.high >= this.t) ++this.joined;
    if (this.joined > before) this.evaluate();
    return this.joined > before;
  }

  private evaluate(): void {
    for (const variable of this.active) variable.log = this.source.at(variable.index);
  }

  // 1 ÷ the square of the scale on which the integrands change here. A slope counts less where the density is lower.
  private demand(): number {
    return this.active.reduce(
      (most, { log }) => Math.max(most, (SLOPE_WEIGHT * log.slope * log.slope) / (1 - log.relative) - log.curvature),
      -this.source.scale().curvature / 8);
  }

  private nextPoint(): number {
    const next = Math.max(this.t - STEP / Math.sqrt(this.demand()), this.end);
    return Math.max(next, this.variables[this.joined]?.high ?? Number.NEGATIVE_INFINITY);
  }

  // Goes to `t`, or to a nearer point if the integrands change too much on the way.
  private stepTo(t: number): void {
    for (;;) {
      this.source.moveTo(t);
      this.evaluate();
      if ((this.t - t) ** 2 * this.demand() <= 4 * STEP * STEP) break;
      t = (t + this.t) / 2;
    }
    const width = this.t - t;
    this.t = t;
    this.updateWins(width);
    if (this.join()) this.updateWins(0);
  }

  private updateWins(width: number): void {
    let allBelow = 1;
    let winRatio = 0; // density of the maximum ÷ P(all are below)
    let winRatioSlope = 0;
    for (const v of this.active) {
      const density = jet(Math.exp(v.logPeak + v.log.relative), v.log.slope, v.log.curvature);
      v.above += between(density, v.density, width);
      v.density = density;
      const below = Math.max(1 - v.above, NO_PROBABILITY);
      allBelow *= below;
      v.ratio = density.value / below;
      v.ratioSlope = v.ratio * (v.log.slope - v.ratio);
      winRatio += v.ratio;
      winRatioSlope += v.ratioSlope;
    }
    for (const v of this.active) {
      const win = jet(allBelow * v.ratio, winRatio + v.log.slope - v.ratio, winRatioSlope + v.log.curvature - v.ratioSlope);
      v.probability += between(win, v.win, width);
      v.win = win;
    }
    this.allBelow = allBelow;
    this.updateShortfall(width, winRatio, winRatioSlope);
  }

  private updateShortfall(width: number, winRatio: number, winRatioSlope: number): void {
    const scale = this.source.scale();
    const rate = jet(scale.rate, scale.slope, scale.curvature);
    const below = jet(this.allBelow, winRatio, winRatioSlope);
    const above = 1 - below.value;
    const shortfall = {
      value: above * rate.value,
      first: above * rate.first - below.first * rate.value,
      second: above * rate.second - 2 * below.first * rate.first - below.second * rate.value,
    };
    this.valueAbove += between(shortfall, this.shortfall, width);
    this.shortfall = shortfall;
  }

  run(): Maximum {
    while (this.t > this.end && this.allBelow > NO_PROBABILITY) {
      const next = this.nextPoint();
      if (!(next < this.t)) break; // the density is narrower than the resolution of t
      this.stepTo(next);
    }
    const probability = new Array<number>(this.variables.length).fill(0);
    for (const v of this.variables) probability[v.index] = Math.max(v.probability, 0);
    const sum = probability.reduce((total, p) => total + p, 0);
    return {
      probability: probability.map((p) => (sum > 0 ? p / sum : 0)),
      expectedValue: this.source.scale().value + this.valueAbove,
    };
  }
}

/** REQUIRES: at least one variable. */
export const integrateMaximum = (variables: Variables): Maximum => new Integral(variables).run();
