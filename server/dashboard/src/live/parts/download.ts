// Saves files through the browser's download.
export function save(name: string, blob: Blob): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

export const download = (name: string, text: string, type: string) => save(name, new Blob([text], { type: `${type};charset=utf-8` }));
