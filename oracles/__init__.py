"""Everything that questions an engine: adapters, scenes, judge, buckets and the campaign."""
