// The theme that the user chose, kept in the browser's local storage.
export const THEMES = ['auto', 'light', 'dark'] as const;
export type Theme = (typeof THEMES)[number];

function show(theme: Theme): void {
  if (theme === 'auto') delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
}

// Returns null if the browser refuses storage, as for a page from a file; the theme button still works.
function kept(): string | null {
  try {
    return localStorage.getItem('theme');
  } catch {
    return null;
  }
}

export function chooseTheme(theme: Theme): void {
  show(theme);
  try {
    localStorage.setItem('theme', theme);
  } catch { /* no storage: see kept */ }
}

// Shows the theme that was chosen last, and returns it.
export function keptTheme(): Theme {
  const theme = THEMES.find((each) => each === kept()) ?? 'auto';
  show(theme);
  return theme;
}
