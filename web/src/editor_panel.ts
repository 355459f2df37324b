// The editor with its bar, and what it asks the server for: the text, problems, the schema, examples.
import type { Connection } from './connection.ts';
import { button, choose, make } from './dom.ts';
import { Editor } from './editor.ts';
import type { DocumentMessage, Problem, SchemaKey } from './protocol.ts';

export interface EditorPanelOptions {
  connection: () => Connection;
  fail: (problem: unknown) => void;
  close: () => void;
}

interface ProblemsAnswer {
  type: string;
  list?: Problem[];
}

export class EditorPanel {
  private editor: Editor | null = null;
  private readonly place: HTMLElement;
  private readonly o: EditorPanelOptions;

  constructor(place: HTMLElement, options: EditorPanelOptions) {
    this.place = place;
    this.o = options;
  }

  focus(): void {
    this.editor?.focus();
  }

  // The text of the file, unless there is one that is not saved.
  async load({ problems }: DocumentMessage): Promise<void> {
    const editor = (this.editor ??= this.make());
    if (editor.isChanged) return;
    try {
      const { text } = await this.o.connection().ask<{ type: string; text: string }>({ type: 'text' });
      if (editor.text !== text) editor.setText(text, true);
      if (problems?.length) editor.showProblems(problems);
    } catch (problem) {
      this.o.fail(problem);
    }
  }

  private make(): Editor {
    const { connection, fail, close } = this.o,
      state = make('p', { class: 'editor-state', role: 'status' });
    const editor = new Editor({
      check: async (text) => (await connection().ask<ProblemsAnswer>({ type: 'check', text })).list ?? [],
      save: async (text) => (await connection().ask<ProblemsAnswer>({ type: 'save', text })).list ?? [],
      onState: (words, hasProblems) => {
        state.textContent = words;
        state.classList.toggle('bad', hasProblems);
      },
    });
    const examples = choose('Begin from', [['', 'an example']], '', (name) => {
      if (!name) return;
      connection()
        .ask<{ type: string; text: string }>({ type: 'example', name })
        .then(({ text }) => editor.setText(text, false))
        .catch(fail);
    });
    const bar = make(
      'div',
      { class: 'editor-bar' },
      button('Save', () => void editor.save(), { class: 'main', title: 'Save and load (Ctrl S)' }),
      button('Problems', () => editor.listProblems()),
      examples,
      button('Close', close),
    );
    this.place.replaceChildren(bar, editor.host, state);
    connection()
      .ask<{ type: string; keys: SchemaKey[] }>({ type: 'schema' })
      .then(({ keys }) => editor.setSchema(keys))
      .catch(fail);
    connection()
      .ask<{ type: string; names: string[] }>({ type: 'examples' })
      .then(({ names }) =>
        examples
          .querySelector('select')!
          .append(...names.map((name) => make('option', { value: name }, name.replace(/\.yaml$/, '')))),
      )
      .catch(fail);
    return editor;
  }
}
