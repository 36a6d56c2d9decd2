import { create } from '@bufbuild/protobuf';
import { expect, test, vi } from 'vitest';
import { MappingSchema, MarkerSetSchema, UploadClipResponseSchema } from '../../api/messages';
import { testScene } from '../../scene/test_scene';
import type { ViewContext } from '../../shell/view';
import { MappingEditor } from './mapping_editor';

// No WebGL.
vi.mock('../../scene/scene', () => ({ createScene: () => undefined }));

test('a mapping replaces none that another file has added since the editor opened', async () => {
  const markerSet = create(MarkerSetSchema, { markerNames: ['Head'] });
  const getMarkerSet = vi.fn(() => Promise.resolve({ markerSet }));
  const added: string[] = [];
  const addMappings = ({ mappingFile }: { mappingFile: string }) => {
    added.push(mappingFile);
    return Promise.resolve({});
  };
  const api = { markerSets: { getMarkerSet, addMappings } };
  const checked = create(UploadClipResponseSchema, {
    points: [{ name: 'skull', markerNames: ['Head'] }],
  });
  const applied = vi.fn();
  const context = { api } as unknown as ViewContext;
  const events = { edited: vi.fn(), applied };
  const editor = new MappingEditor(context, 'demo', 'my rig.bvh', checked, events);
  await vi.waitFor(() => {
    expect(editor.node.querySelector('button')).not.toBeNull();
  });
  // Of the file 'my+rig.bvh'.
  const other = create(MappingSchema, { name: 'page-my_rig', signature: ['cranium'] });
  markerSet.mappings.push(other);
  editor.node.querySelector('button')!.click();
  await vi.waitFor(() => {
    expect(applied).toHaveBeenCalledTimes(1);
  });
  expect(added[0]).toContain('\nmapping "page-my_rig-2"\n');
  editor.dispose();
});

test('a hidden figure has no scene; it can be shown again', () => {
  const scenes: { dispose: () => void; root: { children: unknown[] } }[] = [];
  const newScene = vi.fn(() => {
    const { scene } = testScene();
    const canvas = document.createElement('canvas');
    const fake = Object.assign(scene, { canvas, orbit: { place: vi.fn() }, dispose: vi.fn() });
    scenes.push(fake);
    return fake;
  });
  const checked = create(UploadClipResponseSchema, { points: [{ name: 'skull', zM: 1.7 }] });
  const api = { markerSets: { getMarkerSet: () => new Promise(() => undefined) } };
  const context = { api } as unknown as ViewContext;
  const events = { edited: vi.fn(), applied: vi.fn() };
  const editor = new MappingEditor(context, 'demo', 'a.bvh', checked, events, newScene);
  expect(scenes).toEqual([]);
  const state = () =>
    scenes.map(({ dispose, root }) => [
      vi.mocked(dispose).mock.calls.length,
      root.children.length > 0,
    ]);
  editor.showFigure();
  editor.showFigure();
  expect(state()).toEqual([[0, true]]);
  editor.hideFigure();
  expect(state()).toEqual([[1, false]]);
  editor.showFigure();
  expect(state()).toEqual([
    [1, false],
    [0, true],
  ]);
  editor.dispose();
  expect(state()).toEqual([
    [1, false],
    [1, false],
  ]);
});
