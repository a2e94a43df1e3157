#!/bin/sh
# What the registries would get (docs/release.md): names, versions, licences, changelog and contents of each package, and dry
# runs. Publishes nothing. A registry that cannot be reached, or a tool that is missing, is said and left out.
set -eu
cd "$(dirname "$0")/.."

say() { printf 'release: %s\n' "$*" >&2; }
wrong() {
    say "$*"
    exit 1
}

number() { sed -n 's/^version = "\(.*\)"/\1/p' "$1" | head -n 1; }
version=$(number Cargo.toml)
for crate in crates/gobo-c crates/gobo-python crates/gobo-web; do
    [ "$(number "$crate/Cargo.toml")" = "$version" ] || wrong "$crate is not $version"
done
# In this order: each depends on those before it.
crates="gobo gobo-reference gobo-scene gobo-picture gobo-cli"
package=crates/gobo-web/package/package.json
grep -q "\"version\": \"$version\"" "$package" || wrong "$package is not $version"
grep -q '^## \[Unreleased\]' CHANGELOG.md || grep -q "^## \[$version\]" CHANGELOG.md || wrong "CHANGELOG.md has no part"
for key in description readme keywords categories; do
    grep -q "^$key = " Cargo.toml || wrong "Cargo.toml has no $key"
done

files=$(cargo package -p gobo --list --allow-dirty --quiet)
for file in Cargo.lock README.md CHANGELOG.md LICENSE-APACHE LICENSE-MIT src/lib.rs build.rs wgsl; do
    printf '%s\n' "$files" | grep -q "^$file" || wrong "the crate lacks $file"
done
if printf '%s\n' "$files" | grep -E '^(tests|tools|data|crates|docs/.*\.png)'; then
    wrong "the crate has what is not for dependants, above"
fi
say "crate gobo $version: $(printf '%s\n' "$files" | wc -l) files"
# They are only packed here: `.ci/run` compiles them.
for crate in $crates; do
    cargo package -p "$crate" --list --allow-dirty --quiet | grep -q '^src/lib.rs' || wrong "$crate lacks its library"
done
# shellcheck disable=SC2046
cargo publish $(printf -- '-p %s ' $crates) --dry-run --allow-dirty --no-verify --quiet ||
    say "left out: cargo publish --dry-run, the registry does not answer"

if ls dist/gobo_shadows-"$version"-*.whl >/dev/null 2>&1; then
    target/python/build/bin/python -m pip install --quiet --disable-pip-version-check twine
    target/python/build/bin/python -m twine check --strict dist/gobo_shadows-"$version"-*.whl
    for file in LICENSE-APACHE LICENSE-MIT METADATA; do
        python3 -m zipfile -l "$(ls dist/gobo_shadows-"$version"-*.whl | head -n 1)" | grep -q "$file" || wrong "the wheel lacks $file"
    done
else
    say "left out: the wheel, make python"
fi

if [ -f "dist/gobo-shadows-$version.tgz" ] && command -v npm >/dev/null 2>&1; then
    for file in LICENSE-APACHE LICENSE-MIT README.md index.js index.d.ts view.js gobo_web_bg.wasm; do
        tar -tzf "dist/gobo-shadows-$version.tgz" | grep -qx "package/$file" || wrong "the npm package lacks $file"
    done
    npm publish "./dist/gobo-shadows-$version.tgz" --dry-run --access public
else
    say "left out: the npm package, make web"
fi
say "ready, but for what is left out above"
