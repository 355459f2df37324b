#!/bin/sh
# Checks that a built site asks no other host for scripts, styles, fonts or pictures, and that its search index
# holds a function of the library.
# usage: check_site.sh SITE
set -eu
site=$1
[ -f "$site/index.html" ] || { echo "site: $site holds no site"; exit 1; }
faults=0
asked=$(grep -rnoE '(src=|<link[^>]*href=)"?(https?:)?//[^" >]+' "$site" --include='*.html' | grep -v 'rel="canonical"' || true)
[ -z "$asked" ] || { echo "site: asks other hosts:"; echo "$asked" | head; faults=1; }
styles=$(grep -rnoE '(url\(|@import )["'\'']?(https?:)?//[^")]+' "$site" --include='*.css' || true)
[ -z "$styles" ] || { echo "site: styles ask other hosts:"; echo "$styles" | head; faults=1; }
grep -q '"location":"reference/world.html#tulle_world_step"' "$site/search/search_index.json" ||
    { echo "site: the search does not know tulle_world_step"; faults=1; }
[ $faults = 0 ] && echo "site: asks no other host, knows tulle_world_step"
exit $faults
