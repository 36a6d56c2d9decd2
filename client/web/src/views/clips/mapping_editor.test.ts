import { create } from '@bufbuild/protobuf';
import { expect, test, vi } from 'vitest';
import { MappingSchema, MarkerSetSchema, UploadClipResponseSchema } from '../../api/messages';
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
  const editor = new MappingEditor(context, 'demo', 'my rig.bvh', checked, applied);
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
