// The scene's YAML beside the picture: completion from the schema, problems at their place while one types, save.
//
// CodeMirror lives in a shadow root: there it uses style sheets that a Content-Security-Policy without inline styles allows.
import {
  autocompletion,
  type Completion,
  type CompletionContext,
  completionKeymap,
  type CompletionResult,
} from '@codemirror/autocomplete';
import { defaultKeymap, history, historyKeymap, indentWithTab } from '@codemirror/commands';
import { yaml } from '@codemirror/lang-yaml';
import { bracketMatching, HighlightStyle, indentOnInput, indentUnit, syntaxHighlighting } from '@codemirror/language';
import { type Diagnostic, lintGutter, lintKeymap, openLintPanel, setDiagnostics } from '@codemirror/lint';
import { highlightSelectionMatches, searchKeymap } from '@codemirror/search';
import { EditorState, Prec } from '@codemirror/state';
import { drawSelection, EditorView, highlightActiveLine, keymap, lineNumbers } from '@codemirror/view';
import { tags } from '@lezer/highlight';
import { make } from './dom.ts';
import { findPath } from './path.ts';
import type { Problem, SchemaKey } from './protocol.ts';

const PAUSE = 350; // milliseconds after a key before the text is checked

export interface EditorOptions {
  check: (text: string) => Promise<Problem[]>;
  save: (text: string) => Promise<Problem[]>;
  onState: (words: string, hasProblems: boolean) => void;
}

const plain = (path: string) => path.replaceAll('[]', '').split('.').filter(Boolean).join('.');

function complete(context: CompletionContext, keys: ReadonlyMap<string, SchemaKey>): CompletionResult | null {
  const text = context.state.doc.toString(),
    { path, isValue, key } = findPath(text, context.pos);
  const word = context.matchBefore(/[\w-]*/);
  if (!word || (word.from === word.to && !context.explicit)) return null;
  const place = path.join('.'),
    describe = (each: SchemaKey) =>
      [each.help, each.unit ? `[${each.unit}]` : '', each.default ? `default ${each.default}` : ''].filter(Boolean).join('; ');
  if (isValue) {
    const found = keys.get([place, key].filter(Boolean).join('.'));
    const choices = found?.choices ?? (found?.kind === 'bool' ? ['true', 'false'] : []);
    return choices.length
      ? { from: word.from, options: choices.map((label) => ({ label, type: 'enum', info: found && describe(found) })) }
      : null;
  }
  const options: Completion[] = [];
  for (const [name, each] of keys) {
    const cut = name.lastIndexOf('.');
    if ((cut < 0 ? '' : name.slice(0, cut)) !== place) continue;
    const label = name.slice(cut + 1);
    options.push({ label, type: 'property', detail: each.kind, info: describe(each), apply: `${label}: ` });
  }
  return options.length ? { from: word.from, options } : null;
}

// ---- looks: the page's own colors, which know light and dark ----

const theme = EditorView.theme({
  '&': { height: '100%', fontSize: '13px', color: 'var(--ink)', backgroundColor: 'var(--surface)' },
  '.cm-scroller': { fontFamily: 'ui-monospace, "DejaVu Sans Mono", monospace', lineHeight: '1.5' },
  '.cm-content': { caretColor: 'var(--ink)' },
  '&.cm-focused': { outline: '2px solid var(--accent)', outlineOffset: '-2px' },
  '.cm-cursor': { borderLeftColor: 'var(--ink)' },
  '&.cm-focused .cm-selectionBackground, .cm-selectionBackground, ::selection': { backgroundColor: 'var(--chosen) !important' },
  '.cm-gutters': {
    backgroundColor: 'var(--page)',
    color: 'var(--quiet)',
    border: 'none',
    borderRight: '1px solid var(--line)',
  },
  '.cm-activeLine, .cm-activeLineGutter': { backgroundColor: 'var(--hover)' },
  '.cm-tooltip, .cm-panels': { backgroundColor: 'var(--surface)', color: 'var(--ink)', border: '1px solid var(--line)' },
  '.cm-tooltip-autocomplete ul li[aria-selected]': { backgroundColor: 'var(--accent)', color: 'var(--accent-ink)' },
  '.cm-completionDetail': { color: 'inherit', opacity: '1' },
  '.cm-tooltip.cm-completionInfo': { maxWidth: '240px', padding: '4px 8px' },
  '.cm-diagnostic': { whiteSpace: 'pre-wrap', maxWidth: '420px' },
  '.cm-panel button, .cm-panel input': {
    font: 'inherit',
    color: 'inherit',
    background: 'var(--page)',
    border: '1px solid var(--edge)',
  },
});
const colors = syntaxHighlighting(
  HighlightStyle.define([
    { tag: [tags.propertyName, tags.definition(tags.propertyName)], color: 'var(--accent)' },
    { tag: tags.comment, color: 'var(--quiet)', fontStyle: 'italic' },
    { tag: [tags.string, tags.special(tags.string)], color: 'var(--text-string)' },
    { tag: [tags.number, tags.bool, tags.keyword], color: 'var(--text-number)' },
    { tag: [tags.punctuation, tags.separator, tags.squareBracket, tags.brace], color: 'var(--quiet)' },
  ]),
);

export class Editor {
  readonly host = make('div', { class: 'editor-host' });
  private readonly view: EditorView;
  private readonly options: EditorOptions;
  private keys: ReadonlyMap<string, SchemaKey> = new Map();
  private saved = '';
  private timer = 0;
  private turn = 0;

  constructor(options: EditorOptions) {
    this.options = options;
    const root = this.host.attachShadow({ mode: 'open' }),
      place = make('div', { class: 'place' });
    const sheet = new CSSStyleSheet();
    sheet.replaceSync(':host { display: block; min-height: 0; } div.place { height: 100%; }');
    root.adoptedStyleSheets = [sheet];
    root.append(place);
    this.view = new EditorView({
      root,
      parent: place,
      state: EditorState.create({
        extensions: [
          lineNumbers(),
          history(),
          drawSelection(),
          indentOnInput(),
          indentUnit.of('  '),
          bracketMatching(),
          highlightActiveLine(),
          highlightSelectionMatches(),
          yaml(),
          theme,
          colors,
          lintGutter(),
          EditorState.tabSize.of(2),
          autocompletion({ override: [(context) => complete(context, this.keys)], icons: false }),
          Prec.high(keymap.of([{ key: 'Mod-s', run: () => (void this.save(), true) }])),
          // Tab indents; Escape, then Tab leaves the editor.
          keymap.of([...completionKeymap, ...lintKeymap, ...searchKeymap, ...historyKeymap, ...defaultKeymap, indentWithTab]),
          EditorView.contentAttributes.of({
            'aria-label': 'Scene in YAML. Escape, then Tab leaves the editor',
            spellcheck: 'false',
            tabindex: '0',
          }),
          EditorView.updateListener.of((update) => {
            if (!update.docChanged) return;
            this.tell('checking');
            clearTimeout(this.timer);
            this.timer = window.setTimeout(() => void this.check(), PAUSE);
          }),
        ],
      }),
    });
  }

  get text(): string {
    return this.view.state.doc.toString();
  }

  get isChanged(): boolean {
    return this.text !== this.saved;
  }

  private tell(words: string, hasProblems = false): void {
    this.options.onState(`${this.isChanged ? 'not saved, ' : ''}${words}`, hasProblems);
  }

  setSchema(keys: readonly SchemaKey[]): void {
    this.keys = new Map(keys.map((key) => [plain(key.path), key]));
  }

  // The text of the file, or of an example, which is not saved.
  setText(text: string, isSaved: boolean): void {
    if (isSaved) this.saved = text;
    this.view.dispatch({ changes: { from: 0, to: this.view.state.doc.length, insert: text } });
  }

  focus(): void {
    this.view.focus();
  }

  showProblems(problems: readonly Problem[]): void {
    const { doc } = this.view.state;
    const list = problems.map(({ line, column, message }): Diagnostic => {
      const row = doc.line(Math.min(Math.max(line, 1), doc.lines)),
        from = Math.min(row.from + Math.max(column - 1, 0), row.to);
      const rest = /^[^\s,:}\]#]*/.exec(row.text.slice(from - row.from))![0].length;
      return { from, to: Math.min(from + Math.max(rest, 1), row.to), severity: 'error', message };
    });
    list.sort((a, b) => a.from - b.from);
    this.view.dispatch(setDiagnostics(this.view.state, list));
    this.tell(
      list.length === 0
        ? 'no problems'
        : list.length === 1
          ? `1 problem: ${describe(problems[0])}`
          : `${list.length} problems, first: ${describe(problems[0])}`,
      list.length > 0,
    );
  }

  // The list of problems under the text.
  listProblems(): void {
    openLintPanel(this.view);
  }

  async check(): Promise<void> {
    const turn = ++this.turn;
    try {
      const problems = await this.options.check(this.text);
      if (turn === this.turn) this.showProblems(problems); // the newest text wins
    } catch (problem) {
      this.tell((problem as Error).message, true);
    }
  }

  async save(): Promise<void> {
    const { text } = this;
    clearTimeout(this.timer);
    this.turn++;
    try {
      const problems = await this.options.save(text);
      if (problems.length === 0) this.saved = text;
      this.showProblems(problems);
      if (problems.length === 0) this.tell('saved and loaded');
    } catch (problem) {
      this.tell((problem as Error).message, true);
    }
  }
}

// A problem in another file has no line here.
const describe = ({ line, column, message }: Problem) => (line > 0 ? `line ${line}, column ${column}: ${message}` : message);
