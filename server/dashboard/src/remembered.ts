// Choices that the browser keeps in its local storage. It refuses storage for some pages, as for a page from a file; choices then last
// until the page is closed.
const unkept = new Map<string, string>();

export function remembered(name: string): string | undefined {
  try {
    return localStorage.getItem(name) ?? undefined;
  } catch {
    return unkept.get(name);
  }
}

/** An undefined value forgets the choice. */
export function remember(name: string, value: string | undefined): void {
  try {
    if (value === undefined) localStorage.removeItem(name);
    else localStorage.setItem(name, value);
  } catch {
    unkept.set(name, value ?? '');
  }
}
