// The reader's choice of the theme, which is kept.
export const THEMES = ['auto', 'light', 'dark'] as const;
export type Theme = (typeof THEMES)[number];

function show(theme: Theme): void {
  if (theme === 'auto') delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
}

// A browser may refuse storage to a page from a file; the switch works all the same.
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
  } catch { /* see kept */ }
}

// Shows the theme that was chosen last, and returns it.
export function keptTheme(): Theme {
  const theme = THEMES.find((each) => each === kept()) ?? 'auto';
  show(theme);
  return theme;
}
