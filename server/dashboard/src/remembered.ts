// Choices that the browser keeps in its local storage. It refuses storage for some pages, as for a page from a file.
export function remembered(name: string): string | undefined {
  try {
    return localStorage.getItem(name) ?? undefined;
  } catch {
    return undefined;
  }
}

/** An undefined value forgets the choice. */
export function remember(name: string, value: string | undefined): void {
  try {
    if (value === undefined) localStorage.removeItem(name);
    else localStorage.setItem(name, value);
  } catch { /* The choice lasts until the page is closed. */ }
}
