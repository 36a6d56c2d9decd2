#!/usr/bin/env bash
# Checks which folders each folder may include from. Prints every include in another direction and
# fails if there is one.
set -euo pipefail
cd "$(dirname "$0")/../.."

declare -A may_include=(
  [text]="text"
  [core/motion]="core/motion"
  [core/format]="core/format core/mapping core/motion text"
  [core/export]="core/export core/format core/motion text"
  [core/inspection]="core/inspection core/format core/mapping core/motion"
  [core/mapping]="core/mapping core/motion"
  [core/kinematics]="core/kinematics core/motion"
  [core/tree]="core/tree core/motion"
  [core/graph]="core/graph core/tree core/motion"
  [core/model]="core/model core/graph core/tree core/motion"
  [core/inference]="core/inference core/model core/graph core/tree core/motion"
  [core/recognition]="core/recognition core/inference core/model core/graph core/tree core/motion"
  [core/estimation]="core/estimation core/inference core/model core/graph core/tree core/motion"
  [core/prediction]="core/prediction core/estimation core/recognition core/inference core/model core/graph core/tree core/motion"
  [core/observe]="core/observe core/prediction core/estimation core/recognition core/inference core/model core/graph core/tree core/motion"
  [core/calibration]="core/calibration core/prediction core/recognition core/inference core/model core/graph core/tree core/motion"
  [core/planning]="core/planning core/kinematics core/recognition core/inference core/model core/graph core/tree core/motion"
  [core/view]="core/view core/planning core/kinematics core/recognition core/inference core/model core/graph core/tree core/motion"
  [import]="import core storage/blob text"
  [storage]="storage core text"
  [storage/blob]="storage/blob storage/annotation_store.h storage/records.h core"
  [storage/sql/connection]="storage/sql/connection storage/cancellable_lock.h storage/motion_store.h storage/mutex.h storage/thread_scopes.h core"
  [storage/sql/tables]="storage/sql/tables storage/sql/connection storage/blob storage/access_store.h storage/annotation_store.h storage/clip_segments.h storage/edit_plan.h storage/motion_store.h storage/mutex.h storage/records.h storage/text_query.h storage/thread_scopes.h core"
  [storage/sql/models]="storage/sql/models storage/sql/tables storage/sql/connection storage/blob storage/clip_segments.h storage/motion_store.h storage/records.h storage/thread_scopes.h core"
  [storage/sql]="storage/sql storage/blob storage/access_store.h storage/annotation_store.h storage/cancellable_lock.h storage/clip_segments.h storage/edit_plan.h storage/motion_store.h storage/mutex.h storage/records.h storage/store_maintenance.h storage/store_url.h storage/text_query.h storage/thread_scopes.h core"
  [storage/sqlite]="storage/sqlite storage/sql storage/blob storage/access_store.h storage/annotation_store.h storage/cancellable_lock.h storage/clip_segments.h storage/edit_plan.h storage/motion_store.h storage/mutex.h storage/records.h storage/store_maintenance.h storage/store_url.h storage/text_query.h storage/thread_scopes.h core"
  [storage/migration]="storage/migration storage/postgres storage/sqlite storage/sql storage/store_url.h core"
  [storage/postgres]="storage/postgres storage/sqlite storage/sql storage/blob storage/access_store.h storage/annotation_store.h storage/cancellable_lock.h storage/clip_segments.h storage/edit_plan.h storage/motion_store.h storage/mutex.h storage/records.h storage/store_maintenance.h storage/store_url.h storage/text_query.h storage/thread_scopes.h core text"
  [server]="server import/launch.h storage core text motiondb/v1"
  [server/filter]="server/filter storage core text"
  [server/engine/work]="server/engine/work storage core text"
  [server/engine]="server/engine server/filter import/launch.h storage core text"
  [server/translate]="server/translate server/engine server/filter storage core text motiondb/v1"
  [server/security]="server/security server/translate server/engine storage core text motiondb/v1"
  [server/observability]="server/observability server/http1 server/listen server/security server/engine storage core text"
  [server/rpc]="server/rpc server/observability server/security server/translate server/engine server/filter storage core text motiondb/v1"
  [server/listen]="server/listen server/security server/engine storage/mutex.h core text"
  [server/http1]="server/http1 server/listen text"
  [server/http2]="server/http2 server/listen server/rpc server/observability server/security server/translate server/engine storage/mutex.h core text motiondb/v1"
  [server/gateway]="server/gateway server/http1 server/http2 server/listen server/rpc server/observability server/security server/translate server/engine core text motiondb/v1"
  [server/settings]="server/settings server/rpc server/observability server/security server/engine storage core text"
  [client]="client import/launch.h motiondb text"
)

bad=0
for folder in "${!may_include[@]}"; do
  [ -d "$folder" ] || { echo "check_layers.sh: missing folder: $folder"; bad=1; continue; }
  while IFS=: read -r file line include; do
    allowed=0
    for prefix in ${may_include[$folder]}; do
      case "$include" in "$prefix"|"$prefix"/*) allowed=1 ;; esac
    done
    case "$include" in core/*|import/*|storage/*|server/*|client/*|tests/*|motiondb/*|text/*) ;; *) allowed=1 ;; esac
    if [ "$allowed" = 0 ]; then
      echo "$file:$line: $folder must not include $include"
      bad=1
    fi
  done < <(grep -rnoE --include='*.h' --include='*.cc' '#include [<"][^">]+' "$folder" |
           sed -E 's/#include [<"]//')
done
for folder in core/*/ server/*/ storage/*/ storage/sql/*/; do
  folder=${folder%/}
  if [ -z "${may_include[$folder]:-}" ]; then
    echo "$folder is not listed in check_layers.sh"
    bad=1
  fi
done
if grep -n '#include "server/engine/query/' server/engine/*.h server/engine/*.cc; then
  echo "server/engine must not include server/engine/query, which is above it"
  bad=1
fi
# core has no clock, no threads, no locks (std::call_once is allowed), no files and no unseeded
# randomness.
if grep -rnE --include='*.h' --include='*.cc' \
    '#include <(thread|chrono|fstream|iostream|filesystem)>|std::(thread|async|[a-z_]*mutex|[a-z_]*lock|random_device)\b|\brand\(' core; then
  echo "core/ must not use threads, locks, clocks, files or randomness"
  bad=1
fi
[ "$bad" = 0 ] && echo "layers: every include is allowed"
exit "$bad"
