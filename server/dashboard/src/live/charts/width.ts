// Hooks that return an element's width, and whether it is on the screen.
import { type MutableRef, useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks';

/** Returns a reference to attach to the element, and its width in pixels; 0 before it is known. */
export function useWidth<Type extends Element>() {
  const element = useRef<Type>(null);
  const [width, setWidth] = useState(0);
  useLayoutEffect(() => {
    const target = element.current;
    if (!target) return undefined;
    setWidth(Math.floor(target.clientWidth));
    const observer = new ResizeObserver(() => setWidth(Math.floor(target.clientWidth)));
    observer.observe(target);
    return () => observer.disconnect();
  }, []);
  return { element, width };
}

/** Returns whether a part of the element's figure is on the screen; of the element itself if it is not in a figure. */
export function useIsSeen(element: MutableRef<Element | null>): boolean {
  const [isSeen, setSeen] = useState(true);
  useEffect(() => {
    const target = element.current?.closest('figure') ?? element.current;
    if (!target) return undefined;
    const observer = new IntersectionObserver((entries) => setSeen(entries.at(-1)?.isIntersecting ?? true));
    observer.observe(target);
    return () => observer.disconnect();
  }, []);
  return isSeen;
}
