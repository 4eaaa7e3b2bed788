/** Wraps a function so that it computes its result for an object only once. Views request the results of all rows whenever one is added. */
export function once<Of extends object, Answer>(compute: (of: Of) => Answer): (of: Of) => Answer {
  const known = new WeakMap<Of, { answer: Answer }>();
  return (of) => {
    const before = known.get(of) ?? { answer: compute(of) };
    known.set(of, before);
    return before.answer;
  };
}
