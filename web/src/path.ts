// Where a place in YAML text lies.

// The keys that lead to a place in YAML text, by indentation and by braces in the line.
export function findPath(text: string, place: number): { path: string[]; isValue: boolean; key: string } {
  const lines = text.slice(0, place).split('\n'),
    line = lines.pop()!;
  const path: string[] = [];
  // Braces that are still open in this line.
  const open: { key: string; start: number }[] = [];
  for (let i = 0; i < line.length; i++) {
    if (line[i] === '#') break;
    if (line[i] === '{') open.push({ key: /([\w-]+)\s*:\s*$/.exec(line.slice(0, i))?.[1] ?? '', start: i + 1 });
    if (line[i] === '}') open.pop();
  }
  const indent = /^\s*(?:-\s+)*/.exec(line)![0].length;
  let depth = indent;
  for (let k = lines.length - 1; k >= 0 && depth > 0; k--) {
    const match = /^(\s*(?:-\s+)*)([\w-]+)\s*:/.exec(lines[k]);
    if (!match) continue;
    const column = match[1].length,
      dash = match[1].indexOf('-');
    if (column >= depth) {
      if (dash >= 0 && dash < depth && column === depth) depth = dash + 1; // an item of a list: its keys are brothers
      continue;
    }
    path.unshift(match[2]);
    depth = dash >= 0 ? dash + 1 : column;
  }
  let rest = line.slice(indent);
  if (open.length) {
    path.push(...open.map(({ key }) => key).filter(Boolean));
    rest = line.slice(open.at(-1)!.start);
    const comma = rest.lastIndexOf(',');
    if (!/\[[^\]]*$/.test(rest)) rest = rest.slice(comma + 1);
  }
  const pair = /^\s*([\w-]+)\s*:\s+/.exec(rest);
  return { path, isValue: pair !== null, key: pair?.[1] ?? '' };
}
