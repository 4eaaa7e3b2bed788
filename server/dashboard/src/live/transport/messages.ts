// Reads and writes the protocol's messages as JSON (protobuf's JSON mapping). The types and schemas in src/gen are generated.

/** An enumeration: its values without the prefix that all of them have in the protocol. */
export interface Names { readonly prefix: string; readonly values: Readonly<Record<string, string | number>> }

/** n: number, l: bigint, s: string, b: boolean, y: bytes, e: enumeration, m: message */
type Kind = 'n' | 'l' | 's' | 'b' | 'y' | 'e' | 'm';

interface Field { name: string; kind: Kind; isList: boolean; isOptional: boolean; other?: Names | Schema<unknown> }

/** Describes the messages of type Shape. `fields` is computed on first use, since messages may refer to later ones. */
export interface Schema<Shape> { readonly fields: () => readonly Field[]; readonly shape?: Shape }

/** A message whose missing fields have their default values. */
export type Init<Shape> = Shape extends bigint | Uint8Array ? Shape
  : Shape extends readonly (infer Each)[] ? readonly Init<Each>[]
    : Shape extends object ? { [Name in keyof Shape]?: Init<Shape[Name]> | undefined } : Shape;

interface Method<Streams, Request, Response> { readonly kind: Streams; readonly path: string; readonly input: Schema<Request>; readonly output: Schema<Response> }
export type Unary<Request, Response> = Method<'unary', Request, Response>;
export type Streaming<Request, Response> = Method<'server_streaming', Request, Response>;

type Fields = Record<string, unknown>;

/** Decodes the generated description: each field is its name, "*" (list) or "?" (optional), ":" and its kind. */
export function schemaOf<Shape>(description: string, others: () => readonly (Names | Schema<unknown>)[]): Schema<Shape> {
  let known: Field[] | undefined;
  const decode = (): Field[] => {
    const rest = [...others()];
    return description.split(' ').filter(Boolean).map((text): Field => {
      const [, name, mark, kind] = /^(\w+)([*?]?):(\w)$/.exec(text)!;
      const other = kind === 'e' || kind === 'm' ? rest.shift() : undefined;
      return { name: name!, kind: kind as Kind, isList: mark === '*', isOptional: mark === '?', ...(other && { other }) };
    });
  };
  return { fields: () => known ??= decode() };
}

const ZEROS: Readonly<Record<Exclude<Kind, 'm'>, () => unknown>> = { n: () => 0, l: () => 0n, s: () => '', b: () => false, y: () => new Uint8Array(), e: () => 0 };
const zeroOf = ({ kind }: Field) => (kind === 'm' ? undefined : ZEROS[kind]());

/** Builds a message: each field of the schema has the value that `valueOf` returns, or its default value if that is undefined. */
function build<Shape>(schema: Schema<Shape>, valueOf: (field: Field) => unknown): Shape {
  const message: Fields = {};
  for (const field of schema.fields()) {
    const value = valueOf(field) ?? (field.isList ? [] : field.isOptional ? undefined : zeroOf(field));
    if (value !== undefined) message[field.name] = value;
  }
  return message as Shape;
}

export function create<Shape>(schema: Schema<Shape>, init: NoInfer<Init<Shape>>): Shape {
  return build(schema, ({ name, kind, isList, other }) => {
    const value = (init as Fields)[name];
    if (kind !== 'm' || value === undefined) return value;
    const nested = (each: unknown) => create(other as Schema<unknown>, each as Fields);
    return isList ? (value as unknown[]).map(nested) : nested(value);
  });
}

function expect(isRight: boolean, name: string): void {
  if (!isRight) throw new TypeError(`the field ${name} has another type`);
}

function readNumber(value: unknown, name: string): number {
  expect(typeof value === 'number' || (typeof value === 'string' && value !== '' && (value === 'NaN' || !Number.isNaN(Number(value)))), name);
  return Number(value);
}

function readBytes(value: unknown, name: string): Uint8Array {
  expect(typeof value === 'string', name);
  return Uint8Array.from(atob((value as string).replaceAll('-', '+').replaceAll('_', '/')), (character) => character.charCodeAt(0));
}

function readEnum(value: unknown, { prefix, values }: Names, name: string): number {
  if (typeof value === 'number') return value;
  expect(typeof value === 'string', name);
  const known = values[(value as string).slice(prefix.length)];
  return typeof known === 'number' ? known : 0; // a value that this page does not know
}

function readValue(value: unknown, { name, kind, other }: Field): unknown {
  switch (kind) {
    case 'n': return readNumber(value, name);
    case 'l':
      expect(typeof value === 'number' || (typeof value === 'string' && /^-?\d+$/.test(value)), name);
      return BigInt(value as string | number);
    case 's': expect(typeof value === 'string', name); return value;
    case 'b': expect(typeof value === 'boolean', name); return value;
    case 'y': return readBytes(value, name);
    case 'e': return readEnum(value, other as Names, name);
    default: return readObject(other as Schema<unknown>, value);
  }
}

function readObject<Shape>(schema: Schema<Shape>, json: unknown): Shape {
  expect(typeof json === 'object' && json !== null && !Array.isArray(json), 'of the message');
  return build(schema, (field) => {
    const value = (json as Fields)[field.name];
    if (value === undefined || value === null) return undefined;
    if (!field.isList) return readValue(value, field);
    expect(Array.isArray(value), field.name);
    return (value as unknown[]).map((each) => readValue(each, field));
  });
}

/** Reads a message. Ignores fields that the schema lacks. Throws if the text is not JSON of this type. */
export const fromJsonText = <Shape>(schema: Schema<Shape>, text: string): Shape => readObject(schema, JSON.parse(text));

function writtenValue(value: unknown, { kind, other }: Field): unknown {
  switch (kind) {
    case 'l': return String(value);
    case 'n': return Number.isFinite(value) ? value : String(value);
    case 'y': return btoa(String.fromCharCode(...value as Uint8Array));
    case 'e': {
      const { prefix, values } = other as Names;
      const name = values[value as number];
      return name === undefined ? value : `${prefix}${name}`;
    }
    case 'm': return toJson(other as Schema<unknown>, value);
    default: return value;
  }
}

/** Returns a message as an object for JSON, without fields that have their default values. */
export function toJson<Shape>(schema: Schema<Shape>, message: Shape): Readonly<Fields> {
  const json: Fields = {};
  for (const field of schema.fields()) {
    const value = (message as Fields)[field.name];
    const isDefault = field.isList ? (value as unknown[]).length === 0 : !field.isOptional && (field.kind === 'y' ? (value as Uint8Array).length === 0 : value === zeroOf(field));
    if (value === undefined || isDefault) continue;
    json[field.name] = field.isList ? (value as unknown[]).map((each) => writtenValue(each, field)) : writtenValue(value, field);
  }
  return json;
}

export const toJsonText = <Shape>(schema: Schema<Shape>, message: Shape) => JSON.stringify(toJson(schema, message));
